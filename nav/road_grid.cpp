// SPDX-License-Identifier: Apache-2.0
#include "nav/road_grid.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr int kStraight = 4;
constexpr int kDirections = 8;
constexpr int kDx[kDirections] = {1, 0, -1, 0, 1, -1, -1, 1};  // the straight ones first
constexpr int kDy[kDirections] = {0, 1, 0, -1, 1, 1, -1, -1};
constexpr std::int32_t kLength[kDirections] = {10, 10, 10, 10, 14, 14, 14, 14};
constexpr std::size_t kBuckets = 16;  ///< more than the longest step
constexpr double kLeave_m = 0.5;
constexpr int kWayOut_steps = 3;
constexpr double kPocket_m2 = 1.0;  ///< who can go no farther than this is hemmed in

}  // namespace

void RoadGrid::reset(const CellGrid<std::uint8_t>& cost, double body_radius_m) {
  stride_ = std::max(1, static_cast<int>(0.84 * body_radius_m / cost.resolution_m));
  step_m_ = stride_ * cost.resolution_m;
  cell_columns_ = cost.columns;
  cell_rows_ = cost.rows;
  columns_ = (cost.columns + stride_ - 1) / stride_;
  rows_ = (cost.rows + stride_ - 1) / stride_;
  const std::size_t roads = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  may_stand_.assign(cost.cells.size(), 0);
  is_open_.assign(roads, 0);
  joined_.assign(roads, 0);
  steps_.assign(roads, 0);
  is_noted_.assign(roads, 0);
  for (auto* list : {&changed_, &around_, &farther_}) {
    list->clear();
    list->reserve(roads);
  }
  const auto stride = static_cast<std::size_t>(stride_);
  for (auto* list : {&piece_, &largest_}) list->reserve(stride * stride);
  buckets_.resize(kBuckets);
  for (auto& bucket : buckets_) bucket.reserve(roads / 4 + 64);
  // Where the body may not stand nothing is open, which stands there already. At the start that is nearly everywhere.
  for (std::size_t i = 0; i < cost.cells.size(); ++i) {
    if (cost.cells[i] < kInscribedCost) may_now_stand(cost.cell(i), true);
  }
  join_changed();
}

void RoadGrid::update(const CellGrid<std::uint8_t>& cost, std::span<const std::uint32_t> changed) {
  for (const std::uint32_t i : changed) {
    const bool now = cost.cells[i] < kInscribedCost;
    if (now != (may_stand_[i] != 0)) may_now_stand(cost.cell(i), now);
  }
  join_changed();
}

void RoadGrid::may_now_stand(Cell c, bool may) {
  may_stand_[static_cast<std::size_t>(c.y) * static_cast<std::size_t>(cell_columns_) + static_cast<std::size_t>(c.x)] =
      may ? 1 : 0;
  const std::uint32_t road = road_of(c);
  if (is_noted_[road] == 0) changed_.push_back(road);
  is_noted_[road] = 1;
}

/// By flooding from each cell in turn, side by side; of equal pieces the one with the lowest cell.
void RoadGrid::find_largest_piece(std::uint32_t road) {
  const int x0 = static_cast<int>(road) % columns_ * stride_;
  const int y0 = static_cast<int>(road) / columns_ * stride_;
  const int x1 = std::min(x0 + stride_, cell_columns_);
  const int y1 = std::min(y0 + stride_, cell_rows_);
  const auto index = [&](int x, int y) { return static_cast<std::uint32_t>(y * cell_columns_ + x); };
  largest_.clear();
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) may_stand_[index(x, y)] = may_stand_[index(x, y)] != 0 ? 1 : 0;
  }
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      if (may_stand_[index(x, y)] != 1) continue;
      piece_.assign(1, index(x, y));
      may_stand_[piece_.front()] = 2;
      for (std::size_t k = 0; k < piece_.size(); ++k) {
        const int px = static_cast<int>(piece_[k]) % cell_columns_;
        const int py = static_cast<int>(piece_[k]) / cell_columns_;
        for (int d = 0; d < kStraight; ++d) {
          const int nx = px + kDx[d];
          const int ny = py + kDy[d];
          if (nx < x0 || ny < y0 || nx >= x1 || ny >= y1 || may_stand_[index(nx, ny)] != 1) continue;
          may_stand_[index(nx, ny)] = 2;
          piece_.push_back(index(nx, ny));
        }
      }
      if (piece_.size() > largest_.size()) largest_.swap(piece_);
    }
  }
  is_open_[road] = largest_.empty() ? 0 : 1;
  // All pieces are marked by now.
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) may_stand_[index(x, y)] = may_stand_[index(x, y)] != 0 ? 1 : 0;
  }
  for (const std::uint32_t cell : largest_) may_stand_[cell] = 2;
}

/// Whether some cell of the road cell shares a side with one of its neighbour's.
bool RoadGrid::are_joined(std::uint32_t road, int straight) const {
  const int rx = static_cast<int>(road) % columns_;
  const int ry = static_cast<int>(road) / columns_;
  const int dx = kDx[straight];
  const int dy = kDy[straight];
  if (rx + dx < 0 || ry + dy < 0 || rx + dx >= columns_ || ry + dy >= rows_) return false;
  const int x0 = dx > 0 ? (rx + 1) * stride_ - 1 : rx * stride_;
  const int y0 = dy > 0 ? (ry + 1) * stride_ - 1 : ry * stride_;
  const auto is_in_piece = [&](int x, int y) {
    return may_stand_[static_cast<std::uint32_t>(y * cell_columns_ + x)] == 2;
  };
  for (int k = 0; k < stride_; ++k) {
    const int x = x0 + (dy != 0 ? k : 0);
    const int y = y0 + (dx != 0 ? k : 0);
    if (x >= cell_columns_ || y >= cell_rows_) break;
    if (is_in_piece(x, y) && is_in_piece(x + dx, y + dy)) return true;
  }
  return false;
}

/// Across a corner only if one of the two ways around it exists.
std::uint8_t RoadGrid::steps_from(std::uint32_t road) const {
  const auto leads = [&](std::uint32_t from, int straight) { return (joined_[from] >> straight & 1U) != 0; };
  const auto beside = [&](int straight) {
    return static_cast<std::uint32_t>(static_cast<int>(road) + kDy[straight] * columns_ + kDx[straight]);
  };
  unsigned steps = joined_[road];
  for (int d = kStraight; d < kDirections; ++d) {
    const int across = kDx[d] > 0 ? 0 : 2;
    const int along = kDy[d] > 0 ? 1 : 3;
    const bool is_way =
        (leads(road, across) && leads(beside(across), along)) || (leads(road, along) && leads(beside(along), across));
    if (is_way) steps |= 1U << d;
  }
  return static_cast<std::uint8_t>(steps);
}

/// Appends what `of` holds and is next to, each once, to `all`. is_noted_ is that of `all`.
void RoadGrid::note_neighbours(const std::vector<std::uint32_t>& of, std::vector<std::uint32_t>& all) {
  for (const std::uint32_t road : of) {
    const int x = static_cast<int>(road) % columns_;
    const int y = static_cast<int>(road) / columns_;
    for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, rows_ - 1); ++ny) {
      for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, columns_ - 1); ++nx) {
        const std::uint32_t n = static_cast<std::uint32_t>(ny * columns_ + nx);
        if (is_noted_[n] != 0) continue;
        is_noted_[n] = 1;
        all.push_back(n);
      }
    }
  }
  for (const std::uint32_t road : all) is_noted_[road] = 0;
}

void RoadGrid::join_changed() {
  for (const std::uint32_t road : changed_) {
    is_noted_[road] = 0;
    find_largest_piece(road);
  }
  note_neighbours(changed_, around_);
  for (const std::uint32_t road : around_) {
    unsigned joined = 0;
    for (int d = 0; d < kStraight; ++d) joined |= are_joined(road, d) ? 1U << d : 0U;
    joined_[road] = static_cast<std::uint8_t>(joined);
  }
  note_neighbours(around_, farther_);
  for (const std::uint32_t road : farther_) steps_[road] = steps_from(road);
  changed_.clear();
  around_.clear();
  farther_.clear();
}

bool RoadGrid::best_cell(const CellGrid<std::uint8_t>& cost, std::size_t road, Cell& out) const {
  const int x0 = static_cast<int>(road) % columns_ * stride_;
  const int y0 = static_cast<int>(road) / columns_ * stride_;
  int best = std::numeric_limits<int>::max();
  for (int y = y0; y < std::min(y0 + stride_, cost.rows); ++y) {
    for (int x = x0; x < std::min(x0 + stride_, cost.columns); ++x) {
      if (may_stand_[cost.index({x, y})] != 2) continue;
      const int c = cost.at({x, y});
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

/// The nearest open road cell that is not reached yet, lowest index first, and tenths of a step to it. `from` itself if
/// there is none near.
std::int32_t RoadGrid::way_out(std::uint32_t from, const TravelField& field, std::uint32_t& exit) const {
  const int x = static_cast<int>(from) % columns_;
  const int y = static_cast<int>(from) / columns_;
  std::int32_t best = TravelField::kNever;
  exit = from;
  for (int ny = std::max(y - kWayOut_steps, 0); ny <= std::min(y + kWayOut_steps, rows_ - 1); ++ny) {
    for (int nx = std::max(x - kWayOut_steps, 0); nx <= std::min(x + kWayOut_steps, columns_ - 1); ++nx) {
      const std::uint32_t n = static_cast<std::uint32_t>(ny * columns_ + nx);
      const int dx = std::abs(nx - x);
      const int dy = std::abs(ny - y);
      const std::int32_t tenths = 10 * std::max(dx, dy) + 4 * std::min(dx, dy);
      if (!is_open(n) || field.distance[n] != TravelField::kNever || tenths >= best) continue;
      best = tenths;
      exit = n;
    }
  }
  return best;
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
  from_ = from;
  limit_ = limit;
  if (is_open(from)) {
    seed(from, 0, out);
    return;
  }
  waiting_ = 0;
  out.reached.push_back(from);
  out.touched.push_back(from);
  out.distance[from] = 0;
  out.came_from[from] = from;
  out.leaves_by[from] = from;
}

bool RoadGrid::go_on(TravelField& out, WorkBudget& budget) {
  for (;;) {
    if (!spread(out, budget)) return false;
    // A body that is hemmed in squeezes out, or backs out the way it came: that is not the end of the world.
    if (static_cast<double>(out.reached.size()) * step_m_ * step_m_ >= kPocket_m2) return true;
    std::uint32_t exit = from_;
    const std::int32_t tenths = way_out(from_, out, exit);
    if (exit == from_ || tenths > limit_) return true;
    seed(exit, tenths, out);
  }
}

void RoadGrid::seed(std::uint32_t road, std::int32_t tenths, TravelField& out) {
  out.touched.push_back(road);
  out.distance[road] = tenths;
  out.came_from[road] = from_;
  out.leaves_by[road] = road;
  buckets_[static_cast<std::size_t>(tenths) % kBuckets].push_back(road);
  waiting_ = 1;
  bucket_distance_ = tenths;
  bucket_next_ = 0;
}

bool RoadGrid::spread(TravelField& out, WorkBudget& budget) {
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
      out.reached.push_back(at);
      for (int n = 0; n < kDirections; ++n) {
        if ((steps_[at] >> n & 1U) == 0) continue;
        const std::uint32_t to = static_cast<std::uint32_t>(static_cast<int>(at) + kDy[n] * columns_ + kDx[n]);
        const std::int32_t there = d + kLength[n];
        if (out.distance[to] <= there) continue;
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
