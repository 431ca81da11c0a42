// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/solid_grid.hpp"

#include <algorithm>
#include <cmath>

#include "hal/sim/plan_shape.hpp"

namespace g3d::hal {
namespace {

constexpr double kSmallestSide_m = 0.5;
constexpr double kMostSquares = 1 << 18;
constexpr double kMostEntries = 1 << 21;

struct Rectangle {
  double low_x, low_y, high_x, high_y;
};

Rectangle around(const Primitive& solid, double margin_m) {
  const PlanExtent half = plan_extent(solid);
  return {double{solid.centre_m[0]} - half.x_m - margin_m, double{solid.centre_m[1]} - half.y_m - margin_m,
          double{solid.centre_m[0]} + half.x_m + margin_m, double{solid.centre_m[1]} + half.y_m + margin_m};
}

}  // namespace

SolidGrid::SolidGrid(const World& world, const std::vector<std::int32_t>& indices, double margin_m) : first_(1, 0) {
  if (indices.empty()) return;
  std::vector<Rectangle> rectangles;
  rectangles.reserve(indices.size());
  for (const std::int32_t i : indices) {
    rectangles.push_back(around(world.primitives()[static_cast<std::size_t>(i)], margin_m));
  }
  Rectangle all = rectangles.front();
  for (const Rectangle& r : rectangles) {
    all = {std::min(all.low_x, r.low_x), std::min(all.low_y, r.low_y), std::max(all.high_x, r.high_x),
           std::max(all.high_y, r.high_y)};
  }
  origin_x_m_ = all.low_x;
  origin_y_m_ = all.low_y;
  const auto squares = [&](double from_m, double to_m) { return std::floor((to_m - from_m) / side_m_) + 1.0; };
  for (side_m_ = kSmallestSide_m;; side_m_ *= 2.0) {
    double entries = 0.0;
    for (const Rectangle& r : rectangles) {
      entries += (squares(r.low_x, r.high_x) + 1.0) * (squares(r.low_y, r.high_y) + 1.0);
    }
    const double count = squares(all.low_x, all.high_x) * squares(all.low_y, all.high_y);
    if (count <= kMostSquares && (entries <= kMostEntries || count <= 1.0)) break;
  }
  columns_ = static_cast<int>(squares(all.low_x, all.high_x));
  rows_ = static_cast<int>(squares(all.low_y, all.high_y));

  const auto for_squares = [&](const Rectangle& r, const auto& visit) {
    const auto place = [&](double at_m, double origin_m, int count) {
      return std::clamp(static_cast<int>(std::floor((at_m - origin_m) / side_m_)), 0, count - 1);
    };
    for (int row = place(r.low_y, origin_y_m_, rows_); row <= place(r.high_y, origin_y_m_, rows_); ++row) {
      for (int column = place(r.low_x, origin_x_m_, columns_); column <= place(r.high_x, origin_x_m_, columns_);
           ++column) {
        visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column));
      }
    }
  };
  first_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const Rectangle& r : rectangles) for_squares(r, [&](std::size_t square) { ++first_[square + 1]; });
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  solids_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t n = 0; n < indices.size(); ++n) {
    for_squares(rectangles[n], [&](std::size_t square) { solids_[next[square]++] = indices[n]; });
  }
}

std::span<const std::int32_t> SolidGrid::near(double x_m, double y_m) const {
  const double column = std::floor((x_m - origin_x_m_) / side_m_);
  const double row = std::floor((y_m - origin_y_m_) / side_m_);
  if (!(column >= 0.0 && row >= 0.0 && column < columns_ && row < rows_)) return {};
  const auto square =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  return {solids_.data() + first_[square], first_[square + 1] - first_[square]};
}

}  // namespace g3d::hal
