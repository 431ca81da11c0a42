// SPDX-License-Identifier: Apache-2.0
// Centres of the occupied voxels as a point cloud, in ascending order of M-code: PLY (binary, x y z red green blue) and
// PCD (binary, x y z rgb). Voxels without a colour are written white.
#pragma once

#include <string>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

struct PointCloudOptions {
  bool only_surface = false;  ///< leave out voxels whose six neighbours are all occupied
  hal::Pose T_world_map;      ///< points are written in the world frame
};

struct CloudPoint {
  float x_m = 0, y_m = 0, z_m = 0;
  std::uint8_t r = 255, g = 255, b = 255;
};

[[nodiscard]] std::vector<CloudPoint> occupied_points(const VoxelMap& map, const PointCloudOptions& options = {});
[[nodiscard]] Bytes encode_ply(const std::vector<CloudPoint>& points);
[[nodiscard]] Bytes encode_pcd(const std::vector<CloudPoint>& points);

/// By temporary file, sync and rename. The path's end chooses: `.pcd`, else PLY. Returns the number of points.
[[nodiscard]] hal::Result<std::size_t> write_point_cloud(const VoxelMap& map, const std::string& path,
                                                         const PointCloudOptions& options = {});

}  // namespace g3d::mapper
