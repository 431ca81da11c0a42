// SPDX-License-Identifier: Apache-2.0
#include "nav/move_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "nav/planar_algebra.hpp"

namespace g3d::nav {

Trodden moved(const Trodden& place, const hal::PlanarPose& T_now_before) {
  const hal::PlanarPose there = compose(T_now_before, {place.x_m, place.y_m, 0.0});
  return {place.at_ns, there.x_m, there.y_m};
}

MoveField::MoveField(const CellGrid<CellState>& like) {
  const auto patches = [&](int cells) { return static_cast<int>(std::ceil(cells * like.resolution_m / kPatch_m)) + 1; };
  patches_ = {kPatch_m, like.origin_x_m, like.origin_y_m, patches(like.columns), patches(like.rows), Move{}};
  front_.reserve(patches_.cells.size());
}

Cell MoveField::patch_of(double x_m, double y_m) const {
  const Cell c = patches_.cell_of(x_m, y_m);
  return {std::clamp(c.x, 0, patches_.columns - 1), std::clamp(c.y, 0, patches_.rows - 1)};
}

void MoveField::compute(std::span<const Trodden> way, const mapper::submaps::ChainMove& move) {
  std::fill(patches_.cells.begin(), patches_.cells.end(), Move{});
  front_.clear();
  for (const Trodden& place : way) {
    Move& patch = patches_.at(patch_of(place.x_m, place.y_m));
    if (!patch.is_known) {
      front_.push_back(static_cast<std::uint32_t>(patches_.index(patch_of(place.x_m, place.y_m))));
    }
    patch = {true, on_plane(move.at(place.at_ns))};
  }
  // Outwards from the way, ring by ring.
  std::size_t ring = 0;
  for (int away = 0; away < kReach_patches; ++away) {
    const std::size_t end = front_.size();
    for (; ring < end; ++ring) {
      const Cell c = patches_.cell(front_[ring]);
      constexpr std::array<Cell, 4> kSides{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
      for (const Cell& side : kSides) {
        const Cell next{c.x + side.x, c.y + side.y};
        if (!patches_.contains(next) || patches_.at(next).is_known) continue;
        patches_.at(next) = patches_.at(c);
        front_.push_back(static_cast<std::uint32_t>(patches_.index(next)));
      }
    }
  }
}

Trodden MoveField::moved(const Trodden& place) const {
  return nav::moved(place, patches_.at(patch_of(place.x_m, place.y_m)).T_now_before);
}

// Moves are small beside a patch, so the patch of where a value is now stands for that of where it was.
void MoveField::resample(CellGrid<std::uint8_t>& grid, std::vector<std::uint8_t>& scratch) const {
  std::copy(grid.cells.begin(), grid.cells.end(), scratch.begin());
  std::fill(grid.cells.begin(), grid.cells.end(), std::uint8_t{0});
  const auto corner = [&](int x, int y) {
    return grid.cell_of(patches_.origin_x_m + (x + 1e-6) * kPatch_m, patches_.origin_y_m + (y + 1e-6) * kPatch_m);
  };
  for (const std::uint32_t known : front_) {
    const Cell patch = patches_.cell(known);
    const hal::PlanarPose T_before_now = inverse(patches_.at(patch).T_now_before);
    const double cos = std::cos(T_before_now.heading_rad);
    const double sin = std::sin(T_before_now.heading_rad);
    const Cell low = corner(patch.x, patch.y);
    const Cell high = corner(patch.x + 1, patch.y + 1);
    for (int y = low.y; y < std::min(high.y, grid.rows); ++y) {
      for (int x = low.x; x < std::min(high.x, grid.columns); ++x) {
        const double x_m = grid.centre_x_m({x, y});
        const double y_m = grid.centre_y_m({x, y});
        const Cell before =
            grid.cell_of(T_before_now.x_m + cos * x_m - sin * y_m, T_before_now.y_m + sin * x_m + cos * y_m);
        if (grid.contains(before)) grid.at({x, y}) = scratch[grid.index(before)];
      }
    }
  }
}

}  // namespace g3d::nav
