// SPDX-License-Identifier: Apache-2.0
// Free space by projection: a voxel is free if, in the window of pixels that it covers in the image, some ray ends at
// least `bias` beyond its centre. Blocks are decided as a whole where the depth pyramid allows it.
#pragma once

#include <algorithm>
#include <array>

#include "mapper/cpu/footprint_images.hpp"
#include "mapper/cpu/free_space.hpp"
#include "mapper/cpu/visible_blocks.hpp"

namespace g3d::mapper::cpu {

/// How the projective test imitates exact rays; measured against `dda` (tests/bench/agreement_bench.cpp).
struct ProjectiveTuning {
  float window_scale = 0.95F;     ///< side of the window / side of a square as large as the voxel's silhouette
  float far_bias_chords = -0.4F;  ///< the same as bias_chords against the ends of far readings, which are no surface
  float bias_chords = 0.4F;       ///< how far beyond a voxel's centre a ray must reach, in mean chords of the voxel
};

/// The numbers of one frame's projective test, shared with the plain twin.
struct ProjectiveFrame {
  float window_px_m;  ///< a voxel at depth z m covers window_px_m / z pixels
  float bias_m;
  float bias_units;
  float far_units;
  float far_bias_units;
  float left_px;  ///< see ProjectBrick
  float right_px;
  float top_px;
  float bottom_px;
  std::array<float, 4> reach_px_m;
  float min_z_units;  ///< voxels nearer than half a voxel are left alone
};
[[nodiscard]] ProjectiveFrame projective_frame(const SensorGeometry& sensor, const FrameGeometry& frame,
                                               const ProjectiveTuning& tuning);

/// No smaller window will be asked for, whatever the frame; and in this one.
[[nodiscard]] float smallest_window_px(const SensorGeometry& sensor, const ProjectiveTuning& tuning);
[[nodiscard]] float smallest_footprint_px(const SensorGeometry& sensor, const FrameGeometry& frame,
                                          const ProjectiveFrame& numbers);

class Projective final : public FreeSpace {
 public:
  explicit Projective(const SensorGeometry& sensor, ProjectiveTuning tuning = {});
  void offer(const FrameWork& work) override;

 private:
  /// Flags of a block that has to be looked at voxel by voxel; false if none is free. `levels` of the block, or
  /// nullptr: bricks that are known to be free already are passed over, as nothing can change there.
  [[nodiscard]] bool look(const FrameWork& work, const ProjectiveFrame& numbers, const VisibleBlocks& visible,
                          const BlockView& block, const std::uint8_t* levels, FreeFlags& flags) const;
  /// Is the voxel free by measured rays alone? The slow, plain way: few voxels need it.
  [[nodiscard]] bool is_strong(const FrameWork& work, const ProjectiveFrame& numbers, const BlockView& block,
                               int place) const;
  /// Where to look for voxels of a brick, by the depth of its middle.
  struct Window {
    FootprintImages::Choice choice;
    float cells_per_px = 1;
    float shift_x = 0;
    float shift_y = 0;
    float first_x = 0;
    float first_y = 0;
    float last_x = 0;
    float last_y = 0;
    int stride = 0;
    const std::uint16_t* image = nullptr;
  };
  [[nodiscard]] const Window& window_at(const SensorGeometry& sensor, const ProjectiveFrame& numbers,
                                        float z_units) const {
    const float z_m = std::max(z_units, numbers.min_z_units) * sensor.metres_per_unit;
    const FootprintImages::Choice choice = images_.choose(numbers.window_px_m / z_m);
    return windows_[static_cast<std::size_t>(choice.level)][static_cast<std::size_t>(choice.window_cells)];
  }
  void fill_windows(const hal::CameraModel& camera);
  void fill_tables(const SensorGeometry& sensor, const FrameGeometry& frame);

  ProjectiveTuning tuning_;
  FootprintImages images_;
  std::array<std::array<Window, kMaxWindow + 1>, kMaxLevels> windows_;
  ProjectionTables tables_{};
  std::array<float, kBricksPerBlock> middle_units_{};  ///< depth of a brick's middle behind the block's first voxel
};

}  // namespace g3d::mapper::cpu
