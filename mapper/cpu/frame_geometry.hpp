// SPDX-License-Identifier: Apache-2.0
// Where one frame lies in the grid: the box of blocks that its rays can reach, and the float32 numbers of projection
// and back-projection that every integrator and every twin shares.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/messages.hpp"
#include "mapper/grid.hpp"
#include "mapper/morton.hpp"

namespace g3d::mapper::cpu {

/// Longest side of the box of blocks that any pose's frustum can need. Double, and safe for any positive numbers.
[[nodiscard]] double longest_side_blocks(const hal::CameraModel& camera, double resolution_m, double far_m);

/// What stays the same over all frames.
struct SensorGeometry {
  hal::CameraModel camera;
  float resolution_m = 0.05F;
  std::uint16_t near_raw = 0;  ///< smallest trusted reading
  std::uint16_t far_raw = 0;   ///< largest trusted reading; rays of farther ones end here
  float metres_per_unit = 0.001F;
  std::vector<float> column_slope;  ///< (u - cx) / fx for every column
  std::vector<float> row_slope;     ///< (v - cy) / fy for every row
  int max_side_blocks = 0;          ///< no frame's box has more blocks along an axis

  SensorGeometry(const hal::CameraModel& camera, float resolution_m, float near_m, float far_m);
  [[nodiscard]] std::size_t max_box_blocks() const {
    const auto n = static_cast<std::size_t>(max_side_blocks);
    return n * n * n;
  }
};

/// The box of blocks around one frame's frustum. Blocks are named by x + nx (y + ny z), relative to `origin`.
struct FrameGeometry {
  std::array<float, 9> rotation;       ///< R of T_world_camera, row-major
  std::array<float, 3> translation_m;  ///< t of T_world_camera
  VoxelIndex origin;                   ///< lowest voxel of the box, multiples of 8
  int nx_blocks = 0;
  int ny_blocks = 0;
  int nz_blocks = 0;

  [[nodiscard]] std::uint32_t block_count() const {
    return static_cast<std::uint32_t>(nx_blocks) * static_cast<std::uint32_t>(ny_blocks) *
           static_cast<std::uint32_t>(nz_blocks);
  }
  /// Highest voxel of the box.
  [[nodiscard]] VoxelIndex last() const {
    return {origin.x + 8 * nx_blocks - 1, origin.y + 8 * ny_blocks - 1, origin.z + 8 * nz_blocks - 1};
  }
  [[nodiscard]] std::uint32_t block_id(int bx, int by, int bz) const {
    return static_cast<std::uint32_t>(bx + nx_blocks * (by + ny_blocks * bz));
  }
  [[nodiscard]] BlockKey block_key(int bx, int by, int bz) const {
    return block_of({origin.x + 8 * bx, origin.y + 8 * by, origin.z + 8 * bz});
  }
  [[nodiscard]] BlockKey block_key(std::uint32_t id) const {
    const int row = static_cast<int>(id) / nx_blocks;
    return block_key(static_cast<int>(id) % nx_blocks, row % ny_blocks, row / ny_blocks);
  }
};

/// Nothing if the box would leave the 16-bit grid.
[[nodiscard]] std::optional<FrameGeometry> frame_geometry(const SensorGeometry& sensor,
                                                          const hal::RigidTransform& T_world_camera);

}  // namespace g3d::mapper::cpu
