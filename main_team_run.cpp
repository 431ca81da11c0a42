// SPDX-License-Identifier: Apache-2.0
#include "main_team_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <utility>

#include "hal/kobuki/line_guard.hpp"
#include "main_say.hpp"
#include "net/team_frame.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kTeamSecond_ns = 1'000'000'000;
/// After the last robot is home, for what is still on its way.
constexpr double kTeamSettle_s = 60.0;

/// Radio waves over the floor: so far, and everybody's own luck.
net::RadioModel radio_model(const SimOptions& options) {
  net::RadioModel model;
  model.loss = options.loss;
  model.late = options.loss > 0.0 ? 0.05 : 0.0;
  model.doubled = options.loss > 0.0 ? 0.02 : 0.0;
  model.seed = options.mapping.seed;
  return model;
}

}  // namespace

Team::Team(hal::SimBuilding& building, const std::vector<nav::RobotConfig>& configs, const SimOptions& options,
           net::TeamTrouble trouble, const hal::Observable& observable, double rate_hz)
    : building_(building),
      trouble_(std::move(trouble)),
      coverage_(observable),
      frame_(hal::make_frame(building.camera())),
      frame_period_ns_(static_cast<hal::TimeNs>(1e9 / rate_hz)),
      radio_(static_cast<std::uint32_t>(configs.size()), radio_model(options),
             [this, &options](std::uint32_t from, std::uint32_t to, hal::TimeNs now_ns) {
               return !net::is_cut(trouble_.cuts, from, to, now_ns) &&
                      (options.radio_range_m <= 0.0 || distance_m(from, to) <= options.radio_range_m);
             }) {
  for (std::uint32_t i = 0; i < configs.size(); ++i) {
    members_.push_back(std::make_unique<Member>(*this, i, configs[i], clock_, options));
  }
}

Team::Member::Member(Team& of, std::uint32_t its_number, const nav::RobotConfig& config, hal::Clock& clock,
                     const SimOptions& options)
    : team(of),
      number(its_number),
      robot(config, clock),
      sharing(sharing_options(config, options, number), robot.mapper().map(), *this),
      talk({}, sharing.gossip(), sharing.store(), 0) {
  robot.share(&sharing.view());
  // All maps are in the world's frame: where each begins is known.
  sharing.publish_pose({}, 0);
}

void Team::run(hal::TimeNs limit_ns, bool show_progress) {
  const hal::TimeNs start_ns = clock_.now();
  while (!is_stop_requested() && now_ns_ < limit_ns && !all_are_home()) {
    advance();
    if (show_progress && now_ns_ % kTeamSecond_ns == 0) show(start_ns);
  }
  driving_ns_ = now_ns_;
  for (const auto& member : members_) member->robot.finish_map();
  const auto settled_ns = now_ns_ + static_cast<hal::TimeNs>(kTeamSettle_s * 1e9);
  while (!is_stop_requested() && now_ns_ < settled_ns && !(all_have_told() && all_hold_the_same())) advance();
  settle_ns_ = now_ns_ - driving_ns_;
  if (show_progress) fmt::print(stderr, "\n");
}

net::SharingOptions Team::Member::sharing_options(const nav::RobotConfig& config, const SimOptions& options,
                                                  std::uint32_t number) {
  net::SharingOptions sharing;
  sharing.gossip.self = {number + 1, 1};
  sharing.gossip.seed = options.mapping.seed;
  sharing.gossip.bandwidth_Bps = options.radio_Bps;
  if (config.loops) {
    sharing.is_chain = true;
    sharing.most_submaps = kTeamSubmaps * static_cast<std::size_t>(options.robots);
  }
  // Each base drifts in its own way: where it has been is what its map says, fitted to the others'.
  if (options.mapping.odometry == "aligned") sharing.refine.emplace().is_lockstep = true;
  return sharing;
}

net::StateWord Team::Member::state() const {
  net::StateWord word;
  word.mission = robot.navigator().mission().state();
  word.battery_percent =
      static_cast<std::uint8_t>(std::lround(100.0 * std::clamp(robot.base().battery_charge, 0.0, 1.0)));
  word.radius_m = static_cast<float>(hal::kobuki::kBodyRadius_m);
  word.map_incarnation = sharing.gossip().options().self.incarnation;
  return word;
}

bool Team::Member::send(net::Address to, mapper::ByteSpan message) {
  const std::uint32_t station =
      to == net::kEverybody ? net::SimRadio::kEveryStation : static_cast<std::uint32_t>(to - 1);
  team.radio_.send(number, station, message, team.now_ns_);
  return true;
}

double Team::distance_m(std::uint32_t a, std::uint32_t b) const {
  const hal::PlanarPose from = building_.T_world_base(a);
  const hal::PlanarPose to = building_.T_world_base(b);
  return std::hypot(from.x_m - to.x_m, from.y_m - to.y_m);
}

bool Team::all_hold_the_same() const {
  const auto first = std::find_if(members_.begin(), members_.end(), [](const auto& m) { return m->is_alive(); });
  return std::all_of(first, members_.end(), [&](const auto& member) {
    return !member->is_alive() || member->sharing.store().digest() == (*first)->sharing.store().digest();
  });
}

bool Team::all_are_home() const {
  return std::all_of(members_.begin(), members_.end(), [](const auto& member) { return member->is_through(); });
}

bool Team::all_have_told() const {
  return std::all_of(members_.begin(), members_.end(), [&](const auto& member) {
    return member->robot.loops() == nullptr ||
           (now_ns_ > driving_ns_ + 2 * kTeamSecond_ns && member->sharing.chain_writer().is_up_to_date());
  });
}

void Team::advance() {
  now_ns_ += hal::kobuki::kPacketPeriod_ns;
  building_.advance_to(now_ns_);
  for (const net::RobotDeath& death : trouble_.deaths) {
    Member& member = *members_[death.robot];
    if (now_ns_ < death.at_ns || !member.is_alive()) continue;
    member.died_ns = now_ns_;
    // Its program is gone, but the guard beside it says stop: see LineGuard.
    (void)building_.line(member.number).write(hal::kobuki::kZeroSpeedPacket);
    radio_.forget(death.robot);
  }
  for (const auto& member : members_) {
    if (!member->is_alive()) continue;
    member->robot.on_line(building_.line(member->number), now_ns_);
    if (now_ns_ >= member->next_frame_ns) take_frame(*member);
  }
  radio_.deliver(now_ns_, [this](std::uint32_t from, std::uint32_t to, mapper::ByteSpan message) {
    if (members_[to]->is_alive()) members_[to]->sharing.on_message({from + 1, 1, from + 1}, message, now_ns_);
  });
  for (const auto& member : members_) {
    if (!member->is_alive()) continue;
    const hal::Pose& T_world_map = member->sharing.T_world_map();
    const nav::TeamWord word = net::in_world(member->robot.team_word(now_ns_), T_world_map);
    if (member->talk.on_time(word, member->state(), now_ns_)) {
      member->robot.on_team(net::in_map(member->talk.sight(), T_world_map), now_ns_);
    }
    if (const auto* loops = member->robot.loops(); loops != nullptr && loops->try_borrow_chain()) {
      member->sharing.publish_chain(loops->chain(), now_ns_);
      loops->give_back_chain();
    }
    const auto slots = member->sharing.on_time(now_ns_);
    if (!slots.empty()) member->robot.on_shared(slots, now_ns_);
  }
  if (now_ns_ % kTeamSecond_ns == 0) sample();
}

void Team::take_frame(Member& member) {
  building_.render(member.number, frame_);
  frame_.stamp_ns = now_ns_;
  const std::uint64_t before = member.robot.frames().integrated;
  if (building_.pass_on(member.number, frame_, now_ns_)) member.robot.on_frame(frame_, now_ns_);
  if (member.robot.frames().integrated != before) {
    member.way.push_back({frame_.stamp_ns, *member.robot.last_frame_pose()});
    member.sharing.note_changed(member.robot.mapper().changed_slots());
  }
  ++member.frames;
  member.next_frame_ns = static_cast<hal::TimeNs>(member.frames) * frame_period_ns_;
}

void Team::sample() {
  for (const auto& member : members_) {
    if (!member->is_alive()) continue;
    member->place_error.note(building_.T_world_base(member->number), member->robot.T_world_base());
    nav::Navigator& navigator = member->robot.navigator();
    member->fraction = coverage_.fraction(navigator.ground().states());
    navigator.report().note_coverage(member->fraction, now_ns_);
    if (member->home_ns == 0 && navigator.mission().is_over()) member->home_ns = now_ns_;
  }
}

void Team::show(hal::TimeNs start_ns) const {
  const double simulated_s = static_cast<double>(now_ns_) / 1e9;
  const double real_s = std::max(1e-3, static_cast<double>(clock_.now() - start_ns) / 1e9);
  std::string text;
  for (const auto& member : members_) {
    text += fmt::format("  {}: {:.1f} % {}", member->number + 1, 100.0 * member->fraction,
                        nav::name_of(member->robot.navigator().mission().state()));
  }
  fmt::print(stderr, "\r{:6.0f} s  {:5.1f} x real time{}   ", simulated_s, simulated_s / real_s, text);
}

}  // namespace g3d
