// SPDX-License-Identifier: Apache-2.0
#include "nav/road_grid.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr int kDx[8] = {1, 0, -1, 0, 1, -1, -1, 1};
constexpr int kDy[8] = {0, 1, 0, -1, 1, 1, -1, -1};
constexpr std::int32_t kLength[8] = {10, 10, 10, 10, 14, 14, 14, 14};
constexpr std::size_t kBuckets = 16;  ///< more than the longest step
constexpr double kLeave_m = 0.5;
constexpr int kWayOut_steps = 3;

}  // namespace

void RoadGrid::reset(const CellGrid<std::uint8_t>& cost, double body_radius_m) {
  // Two neighbours together are 2 strides wide: less than the body, which is what closed ground around a wall measures.
  stride_ = std::max(1, static_cast<int>(0.84 * body_radius_m / cost.resolution_m));
  step_m_ = stride_ * cost.resolution_m;
  columns_ = (cost.columns + stride_ - 1) / stride_;
  rows_ = (cost.rows + stride_ - 1) / stride_;
  may_stand_.assign(cost.cells.size(), 0);
  standing_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);
  buckets_.resize(kBuckets);
  for (auto& bucket : buckets_) bucket.reserve(standing_.size() / 4 + 64);
  for (std::uint32_t i = 0; i < cost.cells.size(); ++i) update(cost, std::span(&i, 1));
}

void RoadGrid::update(const CellGrid<std::uint8_t>& cost, std::span<const std::uint32_t> changed) {
  for (const std::uint32_t i : changed) {
    const std::uint8_t now = cost.cells[i] < kInscribedCost;
    if (now == may_stand_[i]) continue;
    may_stand_[i] = now;
    std::uint16_t& count = standing_[road_of(cost.cell(i))];
    count = static_cast<std::uint16_t>(count + (now != 0 ? 1 : -1));
  }
}

bool RoadGrid::best_cell(const CellGrid<std::uint8_t>& cost, std::size_t road, Cell& out) const {
  const int x0 = static_cast<int>(road) % columns_ * stride_;
  const int y0 = static_cast<int>(road) / columns_ * stride_;
  int best = std::numeric_limits<int>::max();
  for (int y = y0; y < std::min(y0 + stride_, cost.rows); ++y) {
    for (int x = x0; x < std::min(x0 + stride_, cost.columns); ++x) {
      const int c = cost.at({x, y});
      if (c >= kInscribedCost) continue;
      const int off = std::abs(2 * (x - x0) + 1 - stride_) + std::abs(2 * (y - y0) + 1 - stride_);
      const int score = c * 64 + off;
      if (score >= best) continue;
      best = score;
      out = {x, y};
    }
  }
  return best != std::numeric_limits<int>::max();
}

void RoadGrid::size_field(TravelField& field) const {
  field.distance.assign(size(), TravelField::kNever);
  field.came_from.assign(size(), 0);
  field.leaves_by.assign(size(), 0);
  field.reached.clear();
  field.reached.reserve(size());
  field.touched.clear();
  field.touched.reserve(size());
}

/// The nearest open road cell, lowest index first, and tenths of a step to it. `from` itself if there is none near.
std::int32_t RoadGrid::way_out(std::uint32_t from, std::uint32_t& exit) const {
  const int x = static_cast<int>(from) % columns_;
  const int y = static_cast<int>(from) / columns_;
  std::int32_t best = std::numeric_limits<std::int32_t>::max();
  for (int ny = std::max(y - kWayOut_steps, 0); ny <= std::min(y + kWayOut_steps, rows_ - 1); ++ny) {
    for (int nx = std::max(x - kWayOut_steps, 0); nx <= std::min(x + kWayOut_steps, columns_ - 1); ++nx) {
      const std::uint32_t n = static_cast<std::uint32_t>(ny * columns_ + nx);
      const int dx = std::abs(nx - x);
      const int dy = std::abs(ny - y);
      const std::int32_t tenths = 10 * std::max(dx, dy) + 4 * std::min(dx, dy);
      if (!is_open(n) || tenths >= best) continue;
      best = tenths;
      exit = n;
    }
  }
  return exit == from ? 0 : best;
}

void RoadGrid::travel(std::uint32_t from, std::int32_t limit, TravelField& out) {
  begin_travel(from, limit, out);
  WorkBudget budget = WorkBudget::unlimited();
  (void)go_on(out, budget);
}

void RoadGrid::begin_travel(std::uint32_t from, std::int32_t limit, TravelField& out) {
  for (const std::uint32_t i : out.touched) out.distance[i] = TravelField::kNever;
  for (auto& bucket : buckets_) bucket.clear();
  out.reached.clear();
  out.touched.clear();
  out.distance[from] = 0;
  out.came_from[from] = from;
  out.leaves_by[from] = from;
  out.touched.push_back(from);
  std::uint32_t seed = from;
  begin_ = 0;
  if (!is_open(from)) {
    begin_ = way_out(from, seed);
    if (seed != from) {
      out.reached.push_back(from);
      out.touched.push_back(seed);
    }
    out.distance[seed] = begin_;
    out.came_from[seed] = from;
    out.leaves_by[seed] = seed;
  }
  buckets_[static_cast<std::size_t>(begin_) % kBuckets].push_back(seed);
  waiting_ = 1;
  from_ = from;
  limit_ = limit;
  bucket_distance_ = begin_;
  bucket_next_ = 0;
}

bool RoadGrid::go_on(TravelField& out, WorkBudget& budget) {
  const std::int32_t leave = static_cast<std::int32_t>(kLeave_m / step_m_ * 10);
  // Dial 1969: lengths of steps are small integers, so that a ring of buckets replaces a heap.
  for (; waiting_ != 0; ++bucket_distance_, bucket_next_ = 0) {
    const std::int32_t d = bucket_distance_;
    auto& bucket = buckets_[static_cast<std::size_t>(d) % kBuckets];
    while (bucket_next_ < bucket.size()) {
      if (budget.is_spent()) return false;
      budget.spend(1);
      const std::uint32_t at = bucket[bucket_next_++];
      --waiting_;
      if (out.distance[at] != d) continue;
      if (d > limit_) {
        out.distance[at] = TravelField::kNever;
        continue;
      }
      if (at != from_ || begin_ == 0) out.reached.push_back(at);
      const int x = static_cast<int>(at) % columns_;
      const int y = static_cast<int>(at) / columns_;
      for (int n = 0; n < 8; ++n) {
        const int nx = x + kDx[n];
        const int ny = y + kDy[n];
        if (nx < 0 || ny < 0 || nx >= columns_ || ny >= rows_) continue;
        const std::uint32_t to = static_cast<std::uint32_t>(ny * columns_ + nx);
        const std::int32_t there = d + kLength[n];
        if (!is_open(to) || out.distance[to] <= there) continue;
        if (out.distance[to] == TravelField::kNever) out.touched.push_back(to);
        out.distance[to] = there;
        out.came_from[to] = at;
        out.leaves_by[to] = d < leave ? to : out.leaves_by[at];
        buckets_[static_cast<std::size_t>(there) % kBuckets].push_back(to);
        ++waiting_;
      }
    }
    bucket.clear();
  }
  return true;
}

double RoadGrid::bearing(std::uint32_t from, std::uint32_t to) const {
  const int dx = static_cast<int>(to) % columns_ - static_cast<int>(from) % columns_;
  const int dy = static_cast<int>(to) / columns_ - static_cast<int>(from) / columns_;
  return std::atan2(dy, dx);
}

double RoadGrid::leave_heading(const TravelField& field, std::uint32_t from, std::uint32_t to) const {
  return bearing(from, field.leaves_by[to]);
}

double RoadGrid::arrive_heading(const TravelField& field, std::uint32_t to) const {
  std::uint32_t back = to;
  for (double m = 0; m < kLeave_m; m += step_m_) back = field.came_from[back];
  return bearing(back, to);
}

}  // namespace g3d::nav
