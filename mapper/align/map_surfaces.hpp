// SPDX-License-Identifier: Apache-2.0
// The surfaces of a finished map, out of its voxels alone: what two maps are aligned by. An occupied voxel with a free
// one beside it is surface; it faces where the free ones are. Means over cells of several voxels say where a wall is to
// a fraction of a voxel. Thread: while nobody writes the map.
#pragma once

#include <span>
#include <vector>

#include "mapper/align/surface_map.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::align {

class MapSurfaces {
 public:
  explicit MapSurfaces(const VoxelMap& map);
  /// Surfaces that are known better than the voxels say, in the map's frame; the map then says what is free.
  MapSurfaces(const VoxelMap& map, std::span<const DepthSample> surfaces);

  [[nodiscard]] const VoxelMap& map() const { return map_; }
  /// How far from a surface what lies on it may be.
  [[nodiscard]] float tolerance_m() const { return tolerance_m_; }
  /// Cells of a few voxels: where surfaces are.
  [[nodiscard]] const SurfaceMap& fine() const { return fine_; }
  /// Cells of a quarter of a metre and more: what a rough guess finds its way by.
  [[nodiscard]] const SurfaceMap& coarse() const { return coarse_; }
  /// One sample per fine piece, in the map's own frame, in no order that matters.
  [[nodiscard]] const std::vector<DepthSample>& samples() const { return samples_; }
  /// Their mean; zero without any.
  [[nodiscard]] const Vector3f& centre_m() const { return centre_m_; }
  [[nodiscard]] const Vector3f& low_m() const { return low_m_; }
  [[nodiscard]] const Vector3f& high_m() const { return high_m_; }

 private:
  void conclude();

  const VoxelMap& map_;
  float tolerance_m_;
  SurfaceMap fine_;
  SurfaceMap coarse_;
  std::vector<DepthSample> samples_;
  Vector3f centre_m_{};
  Vector3f low_m_{};
  Vector3f high_m_{};
};

/// A part of the samples that is even in space, at most `most` of them: the first of each cube of `spacing_m`.
[[nodiscard]] std::vector<DepthSample> evenly(std::span<const DepthSample> samples, float spacing_m, std::size_t most);

}  // namespace g3d::mapper::align
