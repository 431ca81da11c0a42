// SPDX-License-Identifier: Apache-2.0
// The image of ray ends, filtered by the maximum over square windows of many sizes: cell x of the image for window m of
// level L holds the farthest end within m x m cells of 2^L pixels that begin there. A voxel's footprint is then one
// look into the image whose window is as large as the voxel appears.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "mapper/cpu/kernels/kernels.hpp"
#include "mapper/cpu/ray_ends.hpp"
#include "mapper/cpu/thread_pool.hpp"

namespace g3d::mapper::cpu {

inline constexpr int kMaxWindow = 7;  ///< cells; from the second level on windows of 4..7 suffice
inline constexpr int kMaxLevels = 7;

struct FootprintLevel {
  int width = 0;  ///< cells without padding
  int height = 0;
  int stride = 0;  ///< cells
  int rows = 0;    ///< with padding
};

class FootprintImages {
 public:
  /// `smallest_window_px`: no smaller footprint will be asked for.
  FootprintImages(int width_px, int height_px, float smallest_window_px);

  /// `smallest_px`: no smaller footprint will be asked for in this frame.
  void compute(const RayEnds& ends, const Kernels& kernels, ThreadPool& pool, float smallest_px = 0.0F);

  struct Choice {
    int level = 0;
    int window_cells = 1;
  };
  /// The image whose window comes closest to `size_px` (the largest there is for larger ones).
  [[nodiscard]] Choice choose(float size_px) const;
  /// A window that covers size_px pixels around its middle wherever that lies within a cell; nothing if none is so
  /// large.
  [[nodiscard]] std::optional<Choice> covering(float size_px) const;
  [[nodiscard]] const std::uint16_t* image(Choice choice) const {
    if (choice.level == 0 && choice.window_cells == 1) return ends_;
    return images_[static_cast<std::size_t>(choice.level)][static_cast<std::size_t>(choice.window_cells)].data();
  }
  [[nodiscard]] const FootprintLevel& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }
  [[nodiscard]] int level_count() const { return static_cast<int>(levels_.size()); }

 private:
  void widen(int level, int from, int to, const Kernels& kernels, ThreadPool& pool);
  void halve(int level, const Kernels& kernels, ThreadPool& pool);

  const std::uint16_t* ends_ = nullptr;  ///< level 0, window 1: the ray ends themselves
  int smallest_window_;
  float smallest_px_ = 0.0F;
  std::vector<FootprintLevel> levels_;
  std::vector<std::vector<std::vector<std::uint16_t>>> images_;  ///< [level][window], window 1 = the ends themselves
};

}  // namespace g3d::mapper::cpu
