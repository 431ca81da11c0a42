// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "hal/image/png_writer.hpp"
#include "mapper/files/render.hpp"
#include "mapper/files/scene.hpp"

namespace g3d::mapper {
namespace {

constexpr Rgb kUnknown{0.56F, 0.58F, 0.61F};
constexpr Rgb kFree{0.96F, 0.96F, 0.94F};
constexpr Rgb kWay{0.90F, 0.16F, 0.35F};
constexpr std::int32_t kMaxSide_cells = 8192;

struct Column {
  std::int32_t top_k = -1;  ///< highest drawn voxel, -1 = none
  Rgb colour;
  bool is_free = false;
};

/// Columns of the part of the map that the picture shows.
class Columns {
 public:
  Columns(const Grid& grid, const Scene& scene) {
    const auto cell = [&](double x_m) {
      return static_cast<std::int32_t>(std::lround(x_m / static_cast<double>(grid.resolution_m) + 32767.5));
    };
    constexpr std::int32_t kMargin_cells = 3;
    low_x = cell(scene.low_m[0]) - kMargin_cells;
    low_y = cell(scene.low_m[1]) - kMargin_cells;
    width = std::min(cell(scene.high_m[0]) + kMargin_cells - low_x + 1, kMaxSide_cells);
    height = std::min(cell(scene.high_m[1]) + kMargin_cells - low_y + 1, kMaxSide_cells);
    all.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }
  [[nodiscard]] Column* at(std::int32_t x, std::int32_t y) {
    if (x < low_x || y < low_y || x >= low_x + width || y >= low_y + height) return nullptr;
    return &all[static_cast<std::size_t>(y - low_y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x - low_x)];
  }
  std::int32_t low_x, low_y, width, height;
  std::vector<Column> all;
};

void mark_free(const VoxelMap& map, Columns& columns) {
  BlockValues values;
  for (const BlockKey key : map.sorted_keys()) {
    map.read_block(key, values);
    const VoxelIndex origin = block_origin(key);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (state_of(values[i]) != State::free) continue;
      const VoxelIndex place = decode(i);
      if (Column* column = columns.at(origin.x + place.x, origin.y + place.y)) column->is_free = true;
    }
  }
}

/// Light from the upper left on the slope between a column and its neighbours.
float relief(Columns& columns, std::int32_t x, std::int32_t y) {
  const auto height = [&](std::int32_t at_x, std::int32_t at_y, std::int32_t otherwise) {
    const Column* column = columns.at(at_x, at_y);
    return column != nullptr && column->top_k >= 0 ? column->top_k : otherwise;
  };
  const std::int32_t own = columns.at(x, y)->top_k;
  const int slope = (own - height(x - 1, y, own)) + (own - height(x, y + 1, own));
  return std::clamp(1.0F + 0.06F * static_cast<float>(slope), 0.6F, 1.15F);
}

Rgb column_colour(Columns& columns, std::int32_t x, std::int32_t y) {
  const Column* column = columns.at(x, y);
  if (column == nullptr) return kUnknown;
  if (column->top_k >= 0) return column->colour * relief(columns, x, y);
  return column->is_free ? kFree : kUnknown;
}

}  // namespace

std::vector<std::uint8_t> render_top(const VoxelMap& map, const RenderOptions& options) {
  const hal::ImageSize twice{2 * options.size.width_px, 2 * options.size.height_px};
  Picture picture(twice, kUnknown, kUnknown);
  const Scene scene = make_scene(map, options.use_colour);
  if (scene.voxels.empty()) return picture.halved();
  Columns columns(map.grid(), scene);
  mark_free(map, columns);
  constexpr unsigned kBottomFaceOnly = 1U << 5;  // bit of kFaceNormals' last: seen from below alone
  for (const SceneVoxel& voxel : scene.voxels) {
    const bool is_ceiling = voxel.seen_from == kBottomFaceOnly;
    if (is_ceiling || scene.is_above(map.grid().centre_m(voxel.index))) continue;
    Column* column = columns.at(voxel.index.x, voxel.index.y);
    if (column == nullptr || column->top_k >= voxel.index.z) continue;
    column->top_k = voxel.index.z;
    column->colour = voxel.colour;
  }
  const float px_per_cell = std::min(static_cast<float>(twice.width_px) / static_cast<float>(columns.width),
                                     static_cast<float>(twice.height_px) / static_cast<float>(columns.height));
  const float left_px = 0.5F * (static_cast<float>(twice.width_px) - px_per_cell * static_cast<float>(columns.width));
  const float bottom_px =
      0.5F * (static_cast<float>(twice.height_px) + px_per_cell * static_cast<float>(columns.height));
  const auto on_picture = [&](float x_cells, float y_cells) {
    return ScreenPoint{left_px + px_per_cell * x_cells, bottom_px - px_per_cell * y_cells, 1.0F};
  };
  for (std::int32_t y = 0; y < columns.height; ++y) {
    for (std::int32_t x = 0; x < columns.width; ++x) {
      const auto fx = static_cast<float>(x);
      const auto fy = static_cast<float>(y);
      picture.draw_quad(
          {on_picture(fx, fy), on_picture(fx + 1, fy), on_picture(fx + 1, fy + 1), on_picture(fx, fy + 1)},
          column_colour(columns, columns.low_x + x, columns.low_y + y));
    }
  }
  const auto place = [&](const hal::Pose& pose) {
    const auto r = static_cast<double>(map.grid().resolution_m);
    return on_picture(static_cast<float>(pose.translation_m[0] / r + 32768.0 - columns.low_x),
                      static_cast<float>(pose.translation_m[1] / r + 32768.0 - columns.low_y));
  };
  for (std::size_t i = 1; i < options.trajectory.size(); ++i) {
    picture.draw_line(place(options.trajectory[i - 1]), place(options.trajectory[i]), 3.5F, kWay);
  }
  return picture.halved();
}

hal::Result<void> write_top(const VoxelMap& map, const std::string& path, const RenderOptions& options) {
  return hal::write_png_rgb(path, options.size, render_top(map, options));
}

}  // namespace g3d::mapper
