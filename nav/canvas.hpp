// SPDX-License-Identifier: Apache-2.0
// A picture of plain colours in the making: rectangles, discs, lines and small letters, as charts and floor plans need
// them. Whatever lies beyond the edge is not drawn. Cold paths only: it allocates.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "hal/image/image_size.hpp"

namespace g3d::nav {

struct Colour {
  std::uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Colour&) const = default;
};
/// `part_of_b` 0..1.
[[nodiscard]] Colour mix(const Colour& a, const Colour& b, double part_of_b);

struct PointPx {
  double x_px = 0.0;  ///< to the right; pixel 0 covers 0..1
  double y_px = 0.0;  ///< down
};

class Canvas {
 public:
  Canvas(hal::ImageSize size, const Colour& background);

  void set(int x_px, int y_px, const Colour& colour);
  void fill(int x_px, int y_px, int width_px, int height_px, const Colour& colour);
  /// With smooth edges.
  void disc(const PointPx& middle, double radius_px, const Colour& colour);
  /// With round ends and smooth edges.
  void line(const PointPx& from, const PointPx& to, double width_px, const Colour& colour);
  /// Letters of 5 x 7 dots, `dot_px` pixels each; from the upper left corner. What has no glyph is left blank.
  void text(int x_px, int y_px, std::string_view letters, const Colour& colour, int dot_px = 2);
  [[nodiscard]] static int text_width_px(std::string_view letters, int dot_px = 2);

  [[nodiscard]] Colour at(int x_px, int y_px) const;  ///< precondition: inside
  [[nodiscard]] const hal::ImageSize& size() const { return size_; }
  [[nodiscard]] std::span<const std::uint8_t> rgb() const { return rgb_; }

 private:
  [[nodiscard]] std::size_t index(int x_px, int y_px) const {
    return 3 *
           (static_cast<std::size_t>(y_px) * static_cast<std::size_t>(size_.width_px) + static_cast<std::size_t>(x_px));
  }

  hal::ImageSize size_;
  std::vector<std::uint8_t> rgb_;
};

}  // namespace g3d::nav
