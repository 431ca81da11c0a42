// SPDX-License-Identifier: Apache-2.0
#include "tests/support/team_fleet.hpp"

#include <algorithm>
#include <cmath>

#include "net/claim_book.hpp"

namespace g3d::tests {
namespace {

constexpr hal::TimeNs kTeamStep_ns = 20'000'000;
constexpr double kSamePlace_m = 0.3;

}  // namespace

TeamFleet::TeamFleet(const TeamFleetOptions& options)
    : options_(options),
      fleet_(options.fleet),
      bodies_(options.fleet.robots),
      words_(options.fleet.robots),
      talks_(options.fleet.robots) {
  const auto anywhere = [&] {
    hal::SeededRandom& random = fleet_.random();
    return hal::PlanarPose{random.uniform() * options_.extent_m, random.uniform() * options_.extent_m, 0.0};
  };
  for (int i = 0; i < options.places; ++i) places_.push_back({anywhere()});
  for (hal::PlanarPose& body : bodies_) body = anywhere();
  for (std::uint32_t i = 0; i < size(); ++i) {
    talks_[i] = std::make_unique<net::TeamTalk>(options_.talk, fleet_.gossip(i), fleet_.store(i), fleet_.now_ns());
  }
}

void TeamFleet::kill(std::uint32_t i) {
  talks_[i].reset();
  fleet_.kill(i);
}

void TeamFleet::start(std::uint32_t i) {
  fleet_.start(i);
  words_[i] = {};
  talks_[i] = std::make_unique<net::TeamTalk>(options_.talk, fleet_.gossip(i), fleet_.store(i), fleet_.now_ns());
}

int TeamFleet::open_places() const {
  return static_cast<int>(std::count_if(places_.begin(), places_.end(), [](const Place& p) { return p.is_open; }));
}

void TeamFleet::run(hal::TimeNs duration_ns) {
  for (const hal::TimeNs end = fleet_.now_ns() + duration_ns; fleet_.now_ns() < end;) step();
}

void TeamFleet::step() {
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (!is_alive(i)) continue;
    think(i);
    drive(i, static_cast<double>(kTeamStep_ns) * 1e-9);
    const net::StateWord state{nav::MissionState::exploring, 80, 0.18F, 1};
    (void)talks_[i]->on_time(words_[i], state, fleet_.now_ns());
  }
  fleet_.run(kTeamStep_ns);
}

void TeamFleet::think(std::uint32_t i) {
  nav::TeamWord& word = words_[i];
  const nav::TeamSight& sight = talks_[i]->sight();
  word.T_world_base = bodies_[i];
  word.offer_count = 0;
  std::vector<hal::PlanarPose> open;
  for (const Place& place : places_) {
    if (place.is_open) open.push_back(place.at);
  }
  std::sort(open.begin(), open.end(), [&](const hal::PlanarPose& a, const hal::PlanarPose& b) {
    return net::apart_m(a, bodies_[i]) < net::apart_m(b, bodies_[i]);
  });
  const auto is_claimed = [&](const hal::PlanarPose& goal) {
    return std::any_of(sight.mates.begin(), sight.mates.begin() + static_cast<std::ptrdiff_t>(sight.count),
                       [&](const nav::Teammate& mate) {
                         return mate.has_goal && net::apart_m(mate.goal, goal) < options_.talk.assignment.same_m;
                       });
  };
  for (const hal::PlanarPose& goal : open) {
    if (word.offer_count == word.offers.size()) break;
    word.offers[word.offer_count++] = {goal, static_cast<float>(net::apart_m(goal, bodies_[i]) / options_.speed_mps),
                                       100.0F};
  }
  const bool is_open = std::any_of(open.begin(), open.end(),
                                   [&](const hal::PlanarPose& goal) { return net::apart_m(goal, word.goal) < 1e-3; });
  if (!is_open || is_claimed(word.goal)) word.has_goal = false;
  if (sight.assigned) {
    word.has_goal = true;
    word.goal = *sight.assigned;
  }
  for (std::size_t k = 0; k < open.size() && !word.has_goal; ++k) {
    if (is_claimed(open[k])) continue;
    word.has_goal = true;
    word.goal = open[k];
  }
  word.is_moving = word.has_goal;
  word.way_count = word.has_goal ? 2 : 0;
  if (!word.has_goal) return;
  word.way[0] = {static_cast<float>(bodies_[i].x_m), static_cast<float>(bodies_[i].y_m), 0.0F};
  word.way[1] = {static_cast<float>(word.goal.x_m), static_cast<float>(word.goal.y_m),
                 static_cast<float>(net::apart_m(word.goal, bodies_[i]) / options_.speed_mps)};
}

void TeamFleet::drive(std::uint32_t i, double seconds) {
  const nav::TeamWord& word = words_[i];
  if (!word.has_goal) return;
  hal::PlanarPose& body = bodies_[i];
  const double left_m = net::apart_m(word.goal, body), most_m = options_.speed_mps * seconds;
  if (left_m > most_m) {
    body.x_m += (word.goal.x_m - body.x_m) * most_m / left_m;
    body.y_m += (word.goal.y_m - body.y_m) * most_m / left_m;
    return;
  }
  body = word.goal;
  for (Place& place : places_) {
    if (net::apart_m(place.at, body) > kSamePlace_m) continue;
    place.is_open = false;
    for (std::uint32_t other = 0; other < size(); ++other) {
      if (other != i && is_alive(other) && net::apart_m(bodies_[other], body) < kSamePlace_m) ++shared_places_;
    }
  }
}

bool TeamFleet::respects(std::uint32_t i, net::RobotId other) const {
  const nav::TeamSight& sight = talks_[i]->sight();
  return std::any_of(sight.mates.begin(), sight.mates.begin() + static_cast<std::ptrdiff_t>(sight.count),
                     [&](const nav::Teammate& mate) { return mate.robot == other && mate.has_goal; });
}

bool TeamFleet::is_settled() const {
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (!is_alive(i)) continue;
    const net::Cluster& cluster = talk(i).cluster();
    std::vector<net::RobotId> joined;
    for (std::uint32_t k = 0; k < size(); ++k) {
      if (is_alive(k) && fleet_.group(k) == fleet_.group(i)) joined.push_back(k + 1);
    }
    const auto members = cluster.members();
    if (!std::equal(joined.begin(), joined.end(), members.begin(), members.end())) return false;
    const net::RobotId leader = cluster.office().leader;
    if (!std::binary_search(joined.begin(), joined.end(), leader)) return false;
    const net::Cluster& leading = talk(static_cast<std::uint32_t>(leader - 1)).cluster();
    if (!leading.is_leader() || !(leading.office() == cluster.office())) return false;
  }
  return true;
}

}  // namespace g3d::tests
