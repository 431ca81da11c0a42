// SPDX-License-Identifier: Apache-2.0
// A picture in the making: colour and depth per pixel, quads and lines drawn with a depth test, and the two steps that
// make a voxel picture readable: eye-dome lighting (dark seams where depth jumps) and 2x2 averaging.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/image/image_size.hpp"

namespace g3d::mapper {

struct Rgb {
  float r = 0, g = 0, b = 0;  ///< 0..1
};
[[nodiscard]] inline Rgb operator*(const Rgb& c, float f) { return {c.r * f, c.g * f, c.b * f}; }
[[nodiscard]] inline Rgb mix(const Rgb& a, const Rgb& b, float part_of_b) {
  return {a.r + (b.r - a.r) * part_of_b, a.g + (b.g - a.g) * part_of_b, a.b + (b.b - a.b) * part_of_b};
}

/// A point on the picture: pixels, and the distance in metres that the depth test compares.
struct ScreenPoint {
  float x_px = 0, y_px = 0, depth_m = 0;
};

class Picture {
 public:
  Picture(hal::ImageSize size, const Rgb& top, const Rgb& bottom);

  /// Fills a convex quad of one colour. Pixels whose centre lies inside; shared edges leave neither gap nor overlap.
  void draw_quad(const std::array<ScreenPoint, 4>& corners, const Rgb& colour);
  /// A line of round dots; drawn where it is nearer than what is there, faintly where it is hidden.
  void draw_line(const ScreenPoint& from, const ScreenPoint& to, float radius_px, const Rgb& colour);
  /// Darkens each pixel by how far its neighbours at `radius_px` stand in front of it (Boucheny 2009).
  void shade_by_depth(int radius_px, float strength);

  /// R G B bytes of a picture of half the width and height.
  [[nodiscard]] std::vector<std::uint8_t> halved() const;
  [[nodiscard]] const hal::ImageSize& size() const { return size_; }
  [[nodiscard]] bool is_drawn(int x_px, int y_px) const { return depth_[index(x_px, y_px)] < kFar_m; }

 private:
  static constexpr float kFar_m = 1e30F;
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width_px) + static_cast<std::size_t>(x);
  }

  hal::ImageSize size_;
  std::vector<Rgb> colour_;
  std::vector<float> depth_;
};

}  // namespace g3d::mapper
