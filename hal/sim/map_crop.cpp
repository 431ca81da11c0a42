// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/map_crop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace g3d::hal {
namespace {

struct Range {
  int first = 0;
  int end = 0;
};

/// Cells of one axis whose middle lies in [low_m, high_m].
Range cells_between(double low_m, double high_m, double origin_m, double cell_m, int count) {
  const auto bounded = [&](double cells) {
    return static_cast<int>(std::clamp(cells, 0.0, static_cast<double>(count)));
  };
  return {bounded(std::ceil((low_m - origin_m) / cell_m - 0.5)),
          bounded(std::floor((high_m - origin_m) / cell_m + 0.5))};
}

}  // namespace

Result<void> crop_map(MapYaml& yaml, GreyImage& image, const FloorRectangle& crop, std::string_view file) {
  const double r = yaml.resolution_m;
  const int width = image.size.width_px;
  const int height = image.size.height_px;
  const Range x = cells_between(crop.min_x_m, crop.max_x_m, yaml.origin_x_m, r, width);
  const Range y = cells_between(crop.min_y_m, crop.max_y_m, yaml.origin_y_m, r, height);
  if (x.first >= x.end || y.first >= y.end) {
    return Error{Reason::bad_usage,
                 fmt::format("{}: the rectangle {:g},{:g},{:g},{:g} holds nothing of this map, which reaches from "
                             "{:g},{:g} to {:g},{:g} m; choose one that does",
                             file, crop.min_x_m, crop.min_y_m, crop.max_x_m, crop.max_y_m, yaml.origin_x_m,
                             yaml.origin_y_m, yaml.origin_x_m + width * r, yaml.origin_y_m + height * r)};
  }
  GreyImage piece{{x.end - x.first, y.end - y.first}, image.max_value, {}};
  piece.pixels.reserve(static_cast<std::size_t>(piece.size.width_px) * static_cast<std::size_t>(piece.size.height_px));
  // The picture's first row is the far side.
  for (int row = height - y.end; row < height - y.first; ++row) {
    const auto line = image.pixels.begin() + static_cast<std::ptrdiff_t>(row) * width;
    piece.pixels.insert(piece.pixels.end(), line + x.first, line + x.end);
  }
  image = std::move(piece);
  yaml.origin_x_m += x.first * r;
  yaml.origin_y_m += y.first * r;
  return {};
}

}  // namespace g3d::hal
