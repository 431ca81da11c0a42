// SPDX-License-Identifier: Apache-2.0
#include "tests/support/voxel_floor.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::tests {
namespace {

// What is known of a cell: bits, and from which layer above the floor on the air was seen.
constexpr std::uint8_t kAir = 1, kFloor = 2, kWall = 4, kLowestShift = 4;
constexpr double kHalfView_rad = 0.5 * 57.0 / 57.29577951308232;
constexpr double kNear_m = 0.8, kFar_m = 3.5;
constexpr double kCameraHeight_m = 0.5, kFloorFrom_m = 1.1;  // the image's lower edge meets the floor there
constexpr int kRays = 160;
constexpr std::uint8_t kFull = 24, kEmpty = 8;  // levels after two frames
constexpr std::int32_t kFloorLayer = 32767, kTopLayer = kFloorLayer + 12;

std::uint8_t lowest_layer(double distance_m, double resolution_m) {
  const double edge_m = kCameraHeight_m * (1.0 - distance_m / kFloorFrom_m);
  return static_cast<std::uint8_t>(std::max(std::ceil(edge_m / resolution_m), 0.0));
}

bool is_inside(const std::vector<Box>& boxes, double x_m, double y_m) {
  return std::any_of(boxes.begin(), boxes.end(),
                     [&](const Box& b) { return x_m >= b.x0_m && x_m <= b.x1_m && y_m >= b.y0_m && y_m <= b.y1_m; });
}

}  // namespace

VoxelFloor::VoxelFloor(const Box& extent, float resolution_m)
    : map_(mapper::Grid{resolution_m}, mapper::MapCapacity{1U << 14, 1U << 14, 16}),
      seen_(static_cast<double>(resolution_m), extent.x0_m, extent.y0_m,
            static_cast<int>(std::ceil((extent.x1_m - extent.x0_m) / static_cast<double>(resolution_m))),
            static_cast<int>(std::ceil((extent.y1_m - extent.y0_m) / static_cast<double>(resolution_m))), 0) {}

void VoxelFloor::set(nav::Cell c, std::uint8_t flags) {
  if (!seen_.contains(c)) return;
  std::uint8_t& now = seen_.at(c);
  if (now == flags) return;
  now = flags;
  changed_.push_back(c);
}

void VoxelFloor::write(nav::Cell c) {
  const auto x_m = static_cast<float>(seen_.centre_x_m(c));
  const auto y_m = static_cast<float>(seen_.centre_y_m(c));
  const std::uint8_t flags = seen_.at(c);
  for (std::int32_t z = kFloorLayer; z <= kTopLayer; ++z) {
    const mapper::VoxelIndex voxel{map_.grid().to_index(x_m), map_.grid().to_index(y_m), z};
    std::uint8_t level = mapper::kUnknownLevel;
    if (z == kFloorLayer) {
      level = (flags & kFloor) != 0 ? kFull : mapper::kUnknownLevel;
    } else if ((flags & kWall) != 0) {
      level = kFull;
    } else if (z - kFloorLayer > flags >> kLowestShift) {
      level = kEmpty;
    }
    const mapper::BlockKey key = mapper::block_of(voxel);
    const std::uint32_t slot = map_.find_or_insert(key);
    mapper::BlockHeader& header = map_.header(slot);
    if (header.plane == mapper::kNoSlot && !map_.make_dense(header)) continue;
    map_.plane(header.plane)[mapper::encode(voxel) & 511U] = level;
    if (std::find(changed_slots_.begin(), changed_slots_.end(), slot) == changed_slots_.end()) {
      changed_slots_.push_back(slot);
    }
  }
}

void VoxelFloor::look(const KinematicRobot& robot) {
  changed_.clear();
  changed_slots_.clear();
  const hal::PlanarPose& pose = robot.pose();
  for (int i = 0; i < kRays; ++i) {
    const double angle_rad = pose.heading_rad + kHalfView_rad * (2.0 * (i + 0.5) / kRays - 1.0);
    const double dx = std::cos(angle_rad), dy = std::sin(angle_rad);
    double hit_m = 0.0;
    while (hit_m < kFar_m && !is_inside(robot.boxes(), pose.x_m + hit_m * dx, pose.y_m + hit_m * dy)) hit_m += 0.01;
    if (hit_m < kNear_m) continue;
    const nav::Cell wall = seen_.cell_of(pose.x_m + hit_m * dx, pose.y_m + hit_m * dy);
    for (double s = 0.0; s < hit_m; s += 0.02) {
      const nav::Cell c = seen_.cell_of(pose.x_m + s * dx, pose.y_m + s * dy);
      if (!seen_.contains(c) || c == wall) continue;
      // A wall is taken for gone only by a ray that goes well through its cell, not by one that grazes it.
      const double off_m = std::max(std::fabs(seen_.centre_x_m(c) - pose.x_m - s * dx),
                                    std::fabs(seen_.centre_y_m(c) - pose.y_m - s * dy));
      const std::uint8_t before = seen_.at(c);
      if ((before & kWall) != 0 && off_m > 0.3 * seen_.resolution_m) continue;
      const std::uint8_t lowest = lowest_layer(s, seen_.resolution_m);
      const int from = (before & kAir) != 0 ? std::min<int>(before >> kLowestShift, lowest) : lowest;
      set(c, static_cast<std::uint8_t>((before & kFloor) | kAir | (s >= kFloorFrom_m ? kFloor : 0) |
                                       from << kLowestShift));
    }
    if (hit_m < kFar_m) set(wall, kAir | kWall);
  }
  for (const nav::Cell c : changed_) write(c);
}

double VoxelFloor::coverage(const nav::CellGrid<nav::CellState>& of) const {
  std::size_t free = 0, known = 0;
  for (std::size_t i = 0; i < of.cells.size(); ++i) {
    if (of.cells[i] != nav::CellState::free) continue;
    ++free;
    const nav::Cell c = of.cell(i);
    const nav::Cell here = seen_.cell_of(of.centre_x_m(c), of.centre_y_m(c));
    known += seen_.contains(here) && seen_.at(here) != 0 ? 1 : 0;
  }
  return free == 0 ? 0.0 : static_cast<double>(known) / static_cast<double>(free);
}

}  // namespace g3d::tests
