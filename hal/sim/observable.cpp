// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/observable.hpp"

#include <algorithm>

#include "hal/sim/sightings.hpp"

namespace g3d::hal {
namespace {

/// Counts, per cell, the poses from which it was seen.
class SeenBy {
 public:
  explicit SeenBy(std::size_t cells) : count_(cells, 0), last_pose_(cells, 0) {}

  void begin_pose() { ++pose_; }
  void note(std::size_t index) {
    if (last_pose_[index] == pose_ || count_[index] == 255) return;
    last_pose_[index] = pose_;
    ++count_[index];
  }
  [[nodiscard]] int operator[](std::size_t index) const { return count_[index]; }

 private:
  std::uint32_t pose_ = 0;
  std::vector<std::uint8_t> count_;
  std::vector<std::uint32_t> last_pose_;
};

}  // namespace

Result<Observable> find_observable(const World& world, std::span<const PlanarPose> starts,
                                   const ObservableOptions& options) {
  const auto frame = plan_frame(world, options.cell_m);
  if (!frame) return frame.error();
  Observable out;
  out.frame = frame.value();
  const FloorContact floor(world);
  out.reachable = reachable_cells(floor, out.frame, starts, options.reach);
  out.reachable_count = static_cast<std::size_t>(std::count(out.reachable.begin(), out.reachable.end(), 1));

  const Sightings sightings(world, out.frame, options);
  SeenBy seen_by(out.frame.count());
  for (int row = 0; row < out.frame.rows; row += options.lattice_cells) {
    for (int column = 0; column < out.frame.columns; column += options.lattice_cells) {
      if (out.reachable[out.frame.index(column, row)] == 0) continue;
      seen_by.begin_pose();
      sightings.look_from(column, row, [&](std::size_t, std::size_t index) { seen_by.note(index); });
    }
  }

  out.cells.assign(out.frame.count(), SeenCell::not_observable);
  for (int row = 0; row < out.frame.rows; ++row) {
    for (int column = 0; column < out.frame.columns; ++column) {
      const std::size_t index = out.frame.index(column, row);
      if (seen_by[index] < options.poses_needed) continue;
      if (sightings.is_wall(index)) {
        out.cells[index] = SeenCell::wall;
        ++out.wall_count;
      } else if (floor.floor_m(out.frame.x_m(column), out.frame.y_m(row)) > kNoFloor_m) {
        out.cells[index] = SeenCell::free;
        ++out.free_count;
      }
    }
  }
  return out;
}

}  // namespace g3d::hal
