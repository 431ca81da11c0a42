// SPDX-License-Identifier: Apache-2.0
// Free space of the exact rays (`dda`) without walking them: what a walk of every pixel's ray (RayGrid) marks, to the
// last bit, but found from the voxels' side. Where voxels are larger than pixels nearly all of them are decided by one
// pixel each, and whole blocks by the depth pyramid; those cut by a surface or by the image's border try the pixels
// that they cover.
#pragma once

#include <vector>

#include "mapper/cpu/footprint_images.hpp"
#include "mapper/cpu/free_space.hpp"
#include "mapper/cpu/visible_blocks.hpp"

namespace g3d::mapper::cpu {

class ExactRays final : public FreeSpace {
 public:
  explicit ExactRays(const SensorGeometry& sensor);
  void offer(const FrameWork& work) override;

  /// Is this faster than walking? The smaller a voxel appears, the fewer rays share it.
  [[nodiscard]] static bool pays(const SensorGeometry& sensor);

 private:
  void begin_frame(const FrameWork& work);
  /// Flags of a block that has to be looked at; false if none is free. Voxels for which nothing depends on it are left
  /// out: those with a hit, and those of `levels` (may be nullptr) that are as free as can be.
  [[nodiscard]] bool look(const FrameWork& work, const VisibleBlocks& visible, const BlockView& block,
                          const std::uint8_t* levels, const HitRecord* hits, FreeFlags& flags) const;
  [[nodiscard]] bool look_at_brick(const FrameWork& work, const BlockView& block, const SortBrick& brick,
                                   const std::uint8_t* levels, const HitRecord* hits, FreeFlags& flags) const;
  void choose_window(const SensorGeometry& sensor, SortBrick& brick) const;
  [[nodiscard]] bool is_passed(const FrameWork& work, const BlockView& block, std::size_t place, bool strong) const;

  FootprintImages images_;
  std::vector<float> column_slope_;  ///< padded to whole vectors
  // The frame's
  ProjectionTables tables_{};
  SortBrick common_{};  ///< what is the same for all bricks
  RaySearch search_{};
  ExactBounds bounds_;
  std::array<float, 3> half_m_{};  ///< half extents of a voxel along the camera's axes
  std::uint8_t flag_ = kWeakFree;  ///< of what rays pass, measured or not: strong if all are measured
};

}  // namespace g3d::mapper::cpu
