// SPDX-License-Identifier: Apache-2.0
#include "tests/support/tour_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <utility>

#include "nav/motion_limits.hpp"
#include "nav/road_grid.hpp"

namespace g3d::tests {
namespace {

constexpr double kBearing_rad = 6.283185307179586 / kTourBearings;

struct Best {
  int gain = 0;
  int first_bearing = 0;
};

/// The heading that shows most of what is not covered yet. A cell that two rays meet counts once.
Best best_heading(const TourPlace& place, const std::vector<std::uint8_t>& covered, std::vector<std::uint32_t>& mark,
                  std::uint32_t& round) {
  std::array<int, kTourBearings> count{};
  ++round;
  for (std::size_t i = 0; i < place.cells.size(); ++i) {
    if (covered[place.cells[i]] || mark[place.cells[i]] == round) continue;
    mark[place.cells[i]] = round;
    ++count[place.bearing[i]];
  }
  Best best;
  for (int first = 0; first < kTourBearings; ++first) {
    int gain = 0;
    for (int k = 0; k < kTourWindow; ++k) gain += count[static_cast<std::size_t>((first + k) % kTourBearings)];
    if (gain > best.gain) best = {gain, first};
  }
  return best;
}

/// Seconds from view a to view b: turn into the way, drive, turn into the view.
class Times {
 public:
  Times(const nav::CellGrid<std::uint8_t>& costs, double body_radius_m, const std::vector<hal::PlanarPose>& poses)
      : n_(poses.size()), seconds_(n_ * n_, 1e6) {
    nav::RoadGrid roads;
    roads.reset(costs, body_radius_m);
    nav::TravelField field;
    roads.size_field(field);
    const auto road = [&](std::size_t k) { return roads.road_of(costs.cell_of(poses[k].x_m, poses[k].y_m)); };
    const auto turn = [](double from, double to) { return std::abs(nav::wrap_angle(to - from)); };
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

std::vector<TourView> choose_views(const std::vector<TourPlace>& places, const std::vector<std::uint8_t>& wanted,
                                   std::vector<std::uint8_t> covered, double share) {
  std::size_t total = 0;
  std::size_t have = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    total += wanted[i];
    have += wanted[i] && covered[i];
  }
  std::vector<std::uint32_t> mark(wanted.size(), 0);
  std::uint32_t round = 0;
  std::priority_queue<std::pair<int, std::size_t>> queue;  // upper bounds: gains only shrink
  for (std::size_t p = 0; p < places.size(); ++p) queue.emplace(best_heading(places[p], covered, mark, round).gain, p);
  std::vector<TourView> views;
  while (!queue.empty() && static_cast<double>(have) < share * static_cast<double>(total)) {
    const std::size_t p = queue.top().second;
    queue.pop();
    const Best best = best_heading(places[p], covered, mark, round);
    if (best.gain == 0) continue;
    if (!queue.empty() && best.gain < queue.top().first) {
      queue.emplace(best.gain, p);
      continue;
    }
    TourView view;
    view.pose = {places[p].x_m, places[p].y_m,
                 nav::wrap_angle((best.first_bearing + kTourWindow / 2.0) * kBearing_rad)};
    for (std::size_t i = 0; i < places[p].cells.size(); ++i) {
      const int k = (places[p].bearing[i] - best.first_bearing + kTourBearings) % kTourBearings;
      const std::uint32_t cell = places[p].cells[i];
      if (k >= kTourWindow || covered[cell]) continue;
      covered[cell] = 1;
      ++have;
      view.cells.push_back(cell);
    }
    views.push_back(std::move(view));
    queue.emplace(best.gain, p);
  }
  return views;
}

std::vector<std::size_t> order_views(const nav::CellGrid<std::uint8_t>& costs, double body_radius_m,
                                     const std::vector<hal::PlanarPose>& poses) {
  return order(poses.size(), Times(costs, body_radius_m, poses));
}

}  // namespace g3d::tests
