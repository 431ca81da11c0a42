// SPDX-License-Identifier: Apache-2.0
#include "tests/support/offline_tour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "nav/road_grid.hpp"
#include "tests/support/flat_driver.hpp"

namespace g3d::tests {

using nav::Cell;
using nav::CellGrid;
using Mask = CellGrid<std::uint8_t>;

namespace {

constexpr int kBearings = 64;
constexpr int kWindow = 10;  ///< 56 of the camera's 57 degrees
constexpr double kBearing_rad = 6.283185307179586 / kBearings;

struct View {
  hal::PlanarPose pose;
  std::vector<std::uint32_t> cells;
};

struct Place {
  Cell cell;
  std::vector<std::uint32_t> cells;
  std::vector<std::uint8_t> bearing;
};

Place look_from(const Mask& solid, const Mask& observable, Cell at) {
  constexpr int kRays = 512;
  Place place;
  place.cell = at;
  const double x = solid.centre_x_m(at);
  const double y = solid.centre_y_m(at);
  std::vector<std::uint32_t> ray;
  for (int k = 0; k < kRays; ++k) {
    const double angle = (k + 0.5) * (6.283185307179586 / kRays);
    ray.clear();
    double hit = 1e9;
    walk_ray(solid, x, y, std::cos(angle), std::sin(angle), 3.5, [&](std::size_t i, double distance) {
      if (observable.cells[i]) ray.push_back(static_cast<std::uint32_t>(i));
      if (!solid.cells[i]) return true;
      hit = distance;
      return false;
    });
    if (hit < 0.8) continue;
    for (const std::uint32_t i : ray) {
      place.cells.push_back(i);
      place.bearing.push_back(static_cast<std::uint8_t>(k * kBearings / kRays));
    }
  }
  return place;
}

struct Best {
  int gain = 0;
  int first_bearing = 0;
};

/// The heading that shows most of what is not covered yet. A cell that two rays meet counts once.
Best best_heading(const Place& place, const std::vector<std::uint8_t>& covered, std::vector<std::uint32_t>& mark,
                  std::uint32_t& round) {
  std::array<int, kBearings> count{};
  ++round;
  for (std::size_t i = 0; i < place.cells.size(); ++i) {
    if (covered[place.cells[i]] || mark[place.cells[i]] == round) continue;
    mark[place.cells[i]] = round;
    ++count[place.bearing[i]];
  }
  Best best;
  for (int first = 0; first < kBearings; ++first) {
    int gain = 0;
    for (int k = 0; k < kWindow; ++k) gain += count[static_cast<std::size_t>((first + k) % kBearings)];
    if (gain > best.gain) best = {gain, first};
  }
  return best;
}

std::vector<View> cover(const Mask& solid, const Mask& reachable, const Mask& observable,
                        std::vector<std::uint8_t> covered, double share) {
  std::vector<Place> places;
  for (int y = 4; y < solid.rows; y += 8) {
    for (int x = 4; x < solid.columns; x += 8) {
      // The reachable cell nearest to the lattice point, so that narrow places are not missed.
      for (int ring = 0; ring < 16; ++ring) {
        const Cell c{x + ring % 4 - 2, y + ring / 4 - 2};
        if (!solid.contains(c) || !reachable.at(c)) continue;
        places.push_back(look_from(solid, observable, c));
        break;
      }
    }
  }
  std::size_t total = 0;
  std::size_t have = 0;
  for (std::size_t i = 0; i < observable.cells.size(); ++i) {
    total += observable.cells[i];
    have += observable.cells[i] && covered[i];
  }
  std::vector<std::uint32_t> mark(solid.cells.size(), 0);
  std::uint32_t round = 0;
  std::priority_queue<std::pair<int, std::size_t>> queue;  // upper bounds: gains only shrink
  for (std::size_t p = 0; p < places.size(); ++p) queue.emplace(best_heading(places[p], covered, mark, round).gain, p);
  std::vector<View> views;
  while (!queue.empty() && static_cast<double>(have) < share * static_cast<double>(total)) {
    const std::size_t p = queue.top().second;
    queue.pop();
    const Best best = best_heading(places[p], covered, mark, round);
    if (best.gain == 0) continue;
    if (!queue.empty() && best.gain < queue.top().first) {
      queue.emplace(best.gain, p);
      continue;
    }
    View view;
    view.pose = {solid.centre_x_m(places[p].cell), solid.centre_y_m(places[p].cell),
                 wrap_angle((best.first_bearing + kWindow / 2.0) * kBearing_rad)};
    for (std::size_t i = 0; i < places[p].cells.size(); ++i) {
      const int k = (places[p].bearing[i] - best.first_bearing + kBearings) % kBearings;
      const std::uint32_t cell = places[p].cells[i];
      if (k >= kWindow || covered[cell]) continue;
      covered[cell] = 1;
      ++have;
      view.cells.push_back(cell);
    }
    views.push_back(std::move(view));
    queue.emplace(best.gain, p);
  }
  return views;
}

/// Seconds from view a to view b: turn into the way, drive, turn into the view.
class Times {
 public:
  Times(const Mask& costs, const std::vector<hal::PlanarPose>& poses) : n_(poses.size()), seconds_(n_ * n_, 1e6) {
    nav::RoadGrid roads;
    roads.reset(costs, kBodyRadius_m);
    nav::TravelField field;
    roads.size_field(field);
    const auto road = [&](std::size_t k) { return roads.road_of(costs.cell_of(poses[k].x_m, poses[k].y_m)); };
    const auto turn = [](double from, double to) { return std::abs(wrap_angle(to - from)); };
    for (std::size_t a = 0; a < n_; ++a) {
      roads.travel(road(a), nav::TravelField::kNever - 100, field);
      for (std::size_t b = 0; b < n_; ++b) {
        const std::uint32_t to = road(b);
        if (field.distance[to] == nav::TravelField::kNever) continue;
        seconds_[a * n_ + b] = to == road(a) ? turn(poses[a].heading_rad, poses[b].heading_rad)
                                             : field.distance[to] * roads.step_m() / 10 / 0.4 +
                                                   turn(poses[a].heading_rad, roads.leave_heading(field, road(a), to)) +
                                                   turn(roads.arrive_heading(field, to), poses[b].heading_rad);
      }
    }
  }
  [[nodiscard]] double operator()(std::size_t a, std::size_t b) const { return seconds_[a * n_ + b]; }

 private:
  std::size_t n_;
  std::vector<double> seconds_;
};

/// Order of 1..n-1 after 0 that is short: nearest neighbour, then 2-opt and or-opt while they help.
std::vector<std::size_t> order(std::size_t n, const Times& times) {
  std::vector<std::size_t> tour{0};
  std::vector<std::uint8_t> used(n, 0);
  while (tour.size() < n) {
    std::size_t best = 0;
    for (std::size_t b = 1; b < n; ++b) {
      if (!used[b] && (best == 0 || times(tour.back(), b) < times(tour.back(), best))) best = b;
    }
    used[best] = 1;
    tour.push_back(best);
  }
  const auto length = [&](const std::vector<std::size_t>& t) {
    double sum = 0;
    for (std::size_t i = 1; i < t.size(); ++i) sum += times(t[i - 1], t[i]);
    return sum;
  };
  double best = length(tour);
  for (bool better = true; better;) {
    better = false;
    std::vector<std::size_t> trial;
    const auto keep = [&] {
      const double now = length(trial);
      if (now >= best - 1e-9) return;
      best = now;
      tour = trial;
      better = true;
    };
    for (std::size_t i = 1; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        trial = tour;
        std::reverse(trial.begin() + static_cast<std::ptrdiff_t>(i),
                     trial.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        keep();
      }
    }
    for (std::size_t size = 1; size <= 3; ++size) {
      for (std::size_t i = 1; i + size <= n; ++i) {
        for (std::size_t to = 1; to + size <= n; ++to) {
          trial = tour;
          const auto first = trial.begin() + static_cast<std::ptrdiff_t>(i);
          const std::vector<std::size_t> part(first, first + static_cast<std::ptrdiff_t>(size));
          trial.erase(first, first + static_cast<std::ptrdiff_t>(size));
          trial.insert(trial.begin() + static_cast<std::ptrdiff_t>(to), part.begin(), part.end());
          keep();
        }
      }
    }
  }
  return tour;
}

}  // namespace

FlatResult run_offline_tour(FlatSim& sim, const FlatWorld& world, const Mask& reachable, const Mask& observable,
                            double share) {
  FlatResult result;
  std::vector<std::uint8_t> covered(observable.cells.size(), 0);
  for (std::size_t i = 0; i < covered.size(); ++i) covered[i] = sim.ground().cells[i] != nav::CellState::unknown;
  const std::vector<View> views = cover(world.solid, reachable, observable, std::move(covered), share);
  std::vector<hal::PlanarPose> poses{sim.pose()};
  for (const View& view : views) poses.push_back(view.pose);
  const Mask costs = true_costs(world.solid);
  FlatDriver driver(sim, false);
  for (const std::size_t stop : order(poses.size(), Times(costs, poses))) {
    if (stop == 0) continue;
    const auto& cells = views[stop - 1].cells;
    const auto all_seen = [&] {
      return std::all_of(cells.begin(), cells.end(),
                         [&](std::uint32_t i) { return sim.ground().cells[i] != nav::CellState::unknown; });
    };
    if (all_seen()) continue;
    driver.set_goal(poses[stop], &costs);
    ++result.goals;
    while (driver.step() == DriveState::driving) {
      note_progress(sim, result);
      if (all_seen()) break;
    }
  }
  result.ended = true;
  note_end(sim, result);
  return result;
}

}  // namespace g3d::tests
