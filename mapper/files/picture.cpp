// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/picture.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper {
namespace {

/// Twice the signed area of (a, b, p): positive on one side of the edge.
float side_of(const ScreenPoint& a, const ScreenPoint& b, float x, float y) {
  return (b.x_px - a.x_px) * (y - a.y_px) - (b.y_px - a.y_px) * (x - a.x_px);
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::floor(std::clamp(value, 0.0F, 1.0F) * 255.0F + 0.5F));
}

}  // namespace

Picture::Picture(hal::ImageSize size, const Rgb& top, const Rgb& bottom)
    : size_(size), colour_(size.pixel_count()), depth_(size.pixel_count(), kFar_m) {
  for (int y = 0; y < size_.height_px; ++y) {
    const Rgb row = mix(top, bottom, static_cast<float>(y) / static_cast<float>(size_.height_px));
    std::fill_n(colour_.begin() + static_cast<std::ptrdiff_t>(index(0, y)), size_.width_px, row);
  }
}

void Picture::draw_quad(const std::array<ScreenPoint, 4>& corners, const Rgb& colour) {
  const auto [x_low, x_high] = std::minmax({corners[0].x_px, corners[1].x_px, corners[2].x_px, corners[3].x_px});
  const auto [y_low, y_high] = std::minmax({corners[0].y_px, corners[1].y_px, corners[2].y_px, corners[3].y_px});
  if (!(x_high >= 0 && y_high >= 0 && x_low < static_cast<float>(size_.width_px) &&
        y_low < static_cast<float>(size_.height_px)))
    return;
  const int x0 = std::max(0, static_cast<int>(std::ceil(x_low - 0.5F)));
  const int x1 = std::min(size_.width_px - 1, static_cast<int>(std::floor(x_high - 0.5F)));
  const int y0 = std::max(0, static_cast<int>(std::ceil(y_low - 0.5F)));
  const int y1 = std::min(size_.height_px - 1, static_cast<int>(std::floor(y_high - 0.5F)));
  const float depth_m = 0.25F * (corners[0].depth_m + corners[1].depth_m + corners[2].depth_m + corners[3].depth_m);
  const float sign = side_of(corners[0], corners[1], corners[2].x_px, corners[2].y_px) < 0 ? -1.0F : 1.0F;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const float px = static_cast<float>(x) + 0.5F;
      const float py = static_cast<float>(y) + 0.5F;
      bool inside = true;
      for (std::size_t i = 0; i < 4 && inside; ++i)
        inside = sign * side_of(corners[i], corners[(i + 1) % 4], px, py) >= 0;
      const std::size_t at = index(x, y);
      if (!inside || depth_m >= depth_[at]) continue;
      depth_[at] = depth_m;
      colour_[at] = colour;
    }
  }
}

void Picture::draw_line(const ScreenPoint& from, const ScreenPoint& to, float radius_px, const Rgb& colour) {
  const float length_px = std::hypot(to.x_px - from.x_px, to.y_px - from.y_px);
  if (!(length_px < 1e5F)) return;
  const int steps = std::max(1, static_cast<int>(length_px / (0.5F * radius_px)));
  const int reach = static_cast<int>(std::ceil(radius_px));
  for (int i = 0; i <= steps; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(steps);
    const float cx = from.x_px + (to.x_px - from.x_px) * t;
    const float cy = from.y_px + (to.y_px - from.y_px) * t;
    const float depth_m = from.depth_m + (to.depth_m - from.depth_m) * t;
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const int x = static_cast<int>(cx) + dx;
        const int y = static_cast<int>(cy) + dy;
        if (x < 0 || y < 0 || x >= size_.width_px || y >= size_.height_px) continue;
        if (static_cast<float>(dx * dx + dy * dy) > radius_px * radius_px) continue;
        const std::size_t at = index(x, y);
        const bool hidden = depth_m > depth_[at] + 0.05F;
        colour_[at] = mix(colour_[at], colour, hidden ? 0.04F : 1.0F);
        if (!hidden) depth_[at] = std::min(depth_[at], depth_m);
      }
    }
  }
}

void Picture::shade_by_depth(int radius_px, float strength) {
  std::vector<float> log_depth(depth_.size());
  std::transform(depth_.begin(), depth_.end(), log_depth.begin(),
                 [](float d) { return d < kFar_m ? std::log2(d) : 6.0F; });
  const int r = radius_px;
  const std::array<std::array<int, 2>, 8> around{
      {{r, 0}, {-r, 0}, {0, r}, {0, -r}, {r, r}, {-r, r}, {r, -r}, {-r, -r}}};
  for (int y = 0; y < size_.height_px; ++y) {
    for (int x = 0; x < size_.width_px; ++x) {
      const std::size_t at = index(x, y);
      if (depth_[at] >= kFar_m) continue;
      float in_front = 0;
      for (const auto& [dx, dy] : around) {
        const int nx = std::clamp(x + dx, 0, size_.width_px - 1);
        const int ny = std::clamp(y + dy, 0, size_.height_px - 1);
        in_front += std::min(0.1F, std::max(0.0F, log_depth[at] - log_depth[index(nx, ny)]));
      }
      colour_[at] = colour_[at] * std::exp(-strength * in_front / 8.0F);
    }
  }
}

std::vector<std::uint8_t> Picture::halved() const {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * colour_.size() / 4);
  for (int y = 0; y + 1 < size_.height_px; y += 2) {
    for (int x = 0; x + 1 < size_.width_px; x += 2) {
      const std::array<const Rgb*, 4> four{&colour_[index(x, y)], &colour_[index(x + 1, y)], &colour_[index(x, y + 1)],
                                           &colour_[index(x + 1, y + 1)]};
      Rgb mean;
      for (const Rgb* c : four) mean = {mean.r + c->r / 4, mean.g + c->g / 4, mean.b + c->b / 4};
      rgb.insert(rgb.end(), {to_byte(mean.r), to_byte(mean.g), to_byte(mean.b)});
    }
  }
  return rgb;
}

}  // namespace g3d::mapper
