// SPDX-License-Identifier: Apache-2.0
#include "nav/canvas.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr int kGlyphColumns = 5;
constexpr int kGlyphRows = 7;
constexpr int kAdvance_dots = kGlyphColumns + 1;

struct Glyph {
  char letter;
  std::array<std::uint8_t, kGlyphRows> rows;  ///< from the top; bit 4 is the leftmost dot
};

// The letters of common 5 x 7 dot-matrix displays.
constexpr std::array kGlyphs = std::to_array<Glyph>({
    {'0', {0x0E, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0E}}, {'1', {0x04, 0x0C, 0x04, 0x04, 0x04, 0x04, 0x0E}},
    {'2', {0x0E, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1F}}, {'3', {0x1F, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0E}},
    {'4', {0x02, 0x06, 0x0A, 0x12, 0x1F, 0x02, 0x02}}, {'5', {0x1F, 0x10, 0x1E, 0x01, 0x01, 0x11, 0x0E}},
    {'6', {0x06, 0x08, 0x10, 0x1E, 0x11, 0x11, 0x0E}}, {'7', {0x1F, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
    {'8', {0x0E, 0x11, 0x11, 0x0E, 0x11, 0x11, 0x0E}}, {'9', {0x0E, 0x11, 0x11, 0x0F, 0x01, 0x02, 0x0C}},
    {'%', {0x18, 0x19, 0x02, 0x04, 0x08, 0x13, 0x03}}, {'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0C, 0x0C}},
    {',', {0x00, 0x00, 0x00, 0x00, 0x0C, 0x04, 0x08}}, {'-', {0x00, 0x00, 0x00, 0x1F, 0x00, 0x00, 0x00}},
    {'/', {0x00, 0x01, 0x02, 0x04, 0x08, 0x10, 0x00}}, {':', {0x00, 0x0C, 0x0C, 0x00, 0x0C, 0x0C, 0x00}},
    {'a', {0x00, 0x00, 0x0E, 0x01, 0x0F, 0x11, 0x0F}}, {'b', {0x10, 0x10, 0x16, 0x19, 0x11, 0x11, 0x1E}},
    {'c', {0x00, 0x00, 0x0E, 0x10, 0x10, 0x11, 0x0E}}, {'d', {0x01, 0x01, 0x0D, 0x13, 0x11, 0x11, 0x0F}},
    {'e', {0x00, 0x00, 0x0E, 0x11, 0x1F, 0x10, 0x0E}}, {'f', {0x06, 0x09, 0x08, 0x1C, 0x08, 0x08, 0x08}},
    {'g', {0x00, 0x0F, 0x11, 0x11, 0x0F, 0x01, 0x0E}}, {'h', {0x10, 0x10, 0x16, 0x19, 0x11, 0x11, 0x11}},
    {'i', {0x04, 0x00, 0x0C, 0x04, 0x04, 0x04, 0x0E}}, {'j', {0x02, 0x00, 0x06, 0x02, 0x02, 0x12, 0x0C}},
    {'k', {0x10, 0x10, 0x12, 0x14, 0x18, 0x14, 0x12}}, {'l', {0x0C, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0E}},
    {'m', {0x00, 0x00, 0x1A, 0x15, 0x15, 0x11, 0x11}}, {'n', {0x00, 0x00, 0x16, 0x19, 0x11, 0x11, 0x11}},
    {'o', {0x00, 0x00, 0x0E, 0x11, 0x11, 0x11, 0x0E}}, {'p', {0x00, 0x00, 0x1E, 0x11, 0x1E, 0x10, 0x10}},
    {'q', {0x00, 0x00, 0x0D, 0x13, 0x0F, 0x01, 0x01}}, {'r', {0x00, 0x00, 0x16, 0x19, 0x10, 0x10, 0x10}},
    {'s', {0x00, 0x00, 0x0E, 0x10, 0x0E, 0x01, 0x1E}}, {'t', {0x08, 0x08, 0x1C, 0x08, 0x08, 0x09, 0x06}},
    {'u', {0x00, 0x00, 0x11, 0x11, 0x11, 0x13, 0x0D}}, {'v', {0x00, 0x00, 0x11, 0x11, 0x11, 0x0A, 0x04}},
    {'w', {0x00, 0x00, 0x11, 0x11, 0x15, 0x15, 0x0A}}, {'x', {0x00, 0x00, 0x11, 0x0A, 0x04, 0x0A, 0x11}},
    {'y', {0x00, 0x00, 0x11, 0x11, 0x0F, 0x01, 0x0E}}, {'z', {0x00, 0x00, 0x1F, 0x02, 0x04, 0x08, 0x1F}},
});

std::uint8_t mix_channel(std::uint8_t a, std::uint8_t b, double part_of_b) {
  return static_cast<std::uint8_t>(std::lround(a + (b - a) * part_of_b));
}

/// Pixels [first, last] that may be nearer than `reach` to [low, high], within [0, count).
struct Span {
  int first, last;
  Span(double low, double high, double reach, int count)
      : first(static_cast<int>(std::floor(std::clamp(low - reach, 0.0, static_cast<double>(count))))),
        last(static_cast<int>(std::ceil(std::clamp(high + reach, -1.0, count - 1.0)))) {}
};

}  // namespace

Colour mix(const Colour& a, const Colour& b, double part_of_b) {
  const double part = std::clamp(part_of_b, 0.0, 1.0);
  return {mix_channel(a.r, b.r, part), mix_channel(a.g, b.g, part), mix_channel(a.b, b.b, part)};
}

Canvas::Canvas(hal::ImageSize size, const Colour& background) : size_(size), rgb_(3 * size.pixel_count()) {
  fill(0, 0, size.width_px, size.height_px, background);
}

Colour Canvas::at(int x_px, int y_px) const {
  const std::size_t i = index(x_px, y_px);
  return {rgb_[i], rgb_[i + 1], rgb_[i + 2]};
}

void Canvas::set(int x_px, int y_px, const Colour& colour) {
  if (x_px < 0 || y_px < 0 || x_px >= size_.width_px || y_px >= size_.height_px) return;
  const std::size_t i = index(x_px, y_px);
  rgb_[i] = colour.r;
  rgb_[i + 1] = colour.g;
  rgb_[i + 2] = colour.b;
}

void Canvas::fill(int x_px, int y_px, int width_px, int height_px, const Colour& colour) {
  for (int y = std::max(0, y_px); y < std::min(size_.height_px, y_px + height_px); ++y) {
    for (int x = std::max(0, x_px); x < std::min(size_.width_px, x_px + width_px); ++x) set(x, y, colour);
  }
}

void Canvas::disc(const PointPx& middle, double radius_px, const Colour& colour) {
  line(middle, middle, 2.0 * radius_px, colour);
}

void Canvas::line(const PointPx& from, const PointPx& to, double width_px, const Colour& colour) {
  const double reach = 0.5 * width_px + 0.5;
  const Span columns(std::min(from.x_px, to.x_px), std::max(from.x_px, to.x_px), reach, size_.width_px);
  const Span rows(std::min(from.y_px, to.y_px), std::max(from.y_px, to.y_px), reach, size_.height_px);
  const double dx = to.x_px - from.x_px;
  const double dy = to.y_px - from.y_px;
  const double length2 = dx * dx + dy * dy;
  for (int y = rows.first; y <= rows.last; ++y) {
    for (int x = columns.first; x <= columns.last; ++x) {
      const double px = x + 0.5 - from.x_px;
      const double py = y + 0.5 - from.y_px;
      const double along = length2 > 0.0 ? std::clamp((px * dx + py * dy) / length2, 0.0, 1.0) : 0.0;
      const double away = std::hypot(px - along * dx, py - along * dy);
      if (away < reach) set(x, y, mix(at(x, y), colour, reach - away));
    }
  }
}

void Canvas::text(int x_px, int y_px, std::string_view letters, const Colour& colour, int dot_px) {
  for (const char letter : letters) {
    const auto glyph = std::find_if(kGlyphs.begin(), kGlyphs.end(), [&](const Glyph& g) { return g.letter == letter; });
    for (int row = 0; glyph != kGlyphs.end() && row < kGlyphRows; ++row) {
      for (int column = 0; column < kGlyphColumns; ++column) {
        if ((glyph->rows[static_cast<std::size_t>(row)] >> (kGlyphColumns - 1 - column) & 1) == 0) continue;
        fill(x_px + column * dot_px, y_px + row * dot_px, dot_px, dot_px, colour);
      }
    }
    x_px += kAdvance_dots * dot_px;
  }
}

int Canvas::text_width_px(std::string_view letters, int dot_px) {
  return letters.empty() ? 0 : (static_cast<int>(letters.size()) * kAdvance_dots - 1) * dot_px;
}

}  // namespace g3d::nav
