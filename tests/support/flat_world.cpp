// SPDX-License-Identifier: Apache-2.0
#include "tests/support/flat_world.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hal/image/file_bytes.hpp"
#include "hal/image/pgm.hpp"
#include "hal/sim/map_world.hpp"
#include "tests/support/sample_maps.hpp"

namespace g3d::tests {

using nav::Cell;
using nav::CellGrid;
using Mask = CellGrid<std::uint8_t>;

FlatWorld read_flat_world(const std::string& yaml_path, double max_side_m) {
  const auto need = [](auto result) {
    if (!result) throw std::runtime_error(result.error().text);
    return std::move(result.value());
  };
  const hal::MapYaml yaml = need(hal::parse_map_yaml(need(hal::read_text_file(yaml_path, 1U << 16)), yaml_path));
  const std::size_t slash = yaml_path.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : yaml_path.substr(0, slash + 1);
  const hal::GreyImage image = need(hal::read_pgm(folder + yaml.image));
  const int width = image.size.width_px;
  const int height = image.size.height_px;
  // What nobody has measured counts as solid.
  const auto is_free = [&](int x, int y) {
    const double white =
        static_cast<double>(image.pixels[static_cast<std::size_t>(height - 1 - y) * static_cast<std::size_t>(width) +
                                         static_cast<std::size_t>(x)]) /
        image.max_value;
    return (yaml.negate ? white : 1.0 - white) < yaml.free_thresh;
  };
  double sum_x = 0;
  double sum_y = 0;
  double count = 1e-9;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!is_free(x, y)) continue;
      sum_x += x;
      sum_y += y;
      ++count;
    }
  }
  const int times = std::max(1, static_cast<int>(std::lround(yaml.resolution_m / 0.05)));
  const double fine_m = yaml.resolution_m / times;
  const int side = static_cast<int>(max_side_m / fine_m);
  const int columns = std::min(width * times, side);
  const int rows = std::min(height * times, side);
  const int left = std::clamp(static_cast<int>(sum_x / count) * times - columns / 2, 0, width * times - columns);
  const int low = std::clamp(static_cast<int>(sum_y / count) * times - rows / 2, 0, height * times - rows);
  FlatWorld out;
  out.name = yaml_path.substr(folder.size(), yaml_path.rfind('.') - folder.size());
  out.solid = Mask(fine_m, 0.0, 0.0, columns, rows, 0);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const bool border = x == 0 || y == 0 || x == columns - 1 || y == rows - 1;
      out.solid.at({x, y}) = border || !is_free((x + left) / times, (y + low) / times);
    }
  }
  return out;
}

CellGrid<float> clearance_of(const Mask& solid) {
  const int columns = solid.columns;
  const int rows = solid.rows;
  const int reach = static_cast<int>(2.0 / solid.resolution_m);
  CellGrid<float> out(solid.resolution_m, solid.origin_x_m, solid.origin_y_m, columns, rows, 0.0F);
  std::vector<int> up(solid.cells.size());
  for (int x = 0; x < columns; ++x) {
    int d = reach;
    for (int y = 0; y < rows; ++y) up[solid.index({x, y})] = d = solid.at({x, y}) ? 0 : std::min(d + 1, reach);
    for (int y = rows - 1; y >= 0; --y) {
      d = std::min(d + 1, up[solid.index({x, y})]);
      up[solid.index({x, y})] = d;
    }
  }
  std::vector<int> apex(static_cast<std::size_t>(columns));
  std::vector<double> border(static_cast<std::size_t>(columns) + 1);
  for (int y = 0; y < rows; ++y) {
    const int* column = &up[solid.index({0, y})];
    int k = 0;
    apex[0] = 0;
    border[0] = -1e9;
    border[1] = 1e9;
    for (int x = 1; x < columns; ++x) {
      double s = 0;
      for (;;) {
        const int v = apex[static_cast<std::size_t>(k)];
        s = (column[x] * column[x] + x * x - column[v] * column[v] - v * v) / (2.0 * (x - v));
        if (s > border[static_cast<std::size_t>(k)]) break;
        --k;
      }
      ++k;
      apex[static_cast<std::size_t>(k)] = x;
      border[static_cast<std::size_t>(k)] = s;
      border[static_cast<std::size_t>(k) + 1] = 1e9;
    }
    k = 0;
    for (int x = 0; x < columns; ++x) {
      while (border[static_cast<std::size_t>(k) + 1] < x) ++k;
      const int v = apex[static_cast<std::size_t>(k)];
      const double d2 = static_cast<double>(x - v) * (x - v) + static_cast<double>(column[v]) * column[v];
      out.at({x, y}) = static_cast<float>(std::min(std::sqrt(d2) * solid.resolution_m, 2.0));
    }
  }
  return out;
}

Mask standing_room(const Mask& solid) {
  const CellGrid<float> clearance = clearance_of(solid);
  Mask out(solid.resolution_m, solid.origin_x_m, solid.origin_y_m, solid.columns, solid.rows, 0);
  for (std::size_t i = 0; i < out.cells.size(); ++i) out.cells[i] = clearance.cells[i] > kBodyRadius_m;
  return out;
}

Mask connected_part(const Mask& room, Cell from) {
  Mask out(room.resolution_m, room.origin_x_m, room.origin_y_m, room.columns, room.rows, 0);
  if (!room.contains(from) || !room.at(from)) return out;
  std::vector<Cell> open{from};
  out.at(from) = 1;
  while (!open.empty()) {
    const Cell c = open.back();
    open.pop_back();
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell n{c.x + dx, c.y + dy};
        if (!room.contains(n) || !room.at(n) || out.at(n)) continue;
        out.at(n) = 1;
        open.push_back(n);
      }
    }
  }
  return out;
}

hal::PlanarPose choose_start(const FlatWorld& world, std::uint64_t seed) {
  const Mask room = standing_room(world.solid);
  const CellGrid<float> clearance = clearance_of(world.solid);
  Mask seen = room;
  Mask largest;
  std::size_t most = 0;
  for (std::size_t i = 0; i < room.cells.size(); ++i) {
    if (!seen.cells[i]) continue;
    Mask part = connected_part(room, room.cell(i));
    std::size_t size = 0;
    for (std::size_t k = 0; k < part.cells.size(); ++k) {
      size += part.cells[k];
      if (part.cells[k]) seen.cells[k] = 0;
    }
    if (size > most) {
      most = size;
      largest = std::move(part);
    }
  }
  Random random(seed * 7919 + 17);
  for (;;) {
    const std::size_t i = random.below(static_cast<std::uint32_t>(room.cells.size()));
    if (!largest.cells[i] || clearance.cells[i] < kBodyRadius_m + 0.07) continue;
    const Cell c = room.cell(i);
    return {room.centre_x_m(c), room.centre_y_m(c), random.uniform(-3.14159, 3.14159)};
  }
}

Mask observable_cells(const Mask& solid, const Mask& reachable, double near_m, double far_m) {
  Mask count(solid.resolution_m, solid.origin_x_m, solid.origin_y_m, solid.columns, solid.rows, 0);
  const int stride = std::max(1, static_cast<int>(std::lround(0.2 / solid.resolution_m)));
  std::vector<std::uint32_t> last(solid.cells.size(), 0);
  std::uint32_t pose = 0;
  constexpr int kRays = 512;
  for (int y = stride / 2; y < solid.rows; y += stride) {
    for (int x = stride / 2; x < solid.columns; x += stride) {
      if (!reachable.at({x, y})) continue;
      ++pose;
      const auto see = [&](std::size_t i) {
        if (last[i] == pose) return;
        last[i] = pose;
        count.cells[i] = static_cast<std::uint8_t>(std::min(count.cells[i] + 1, 3));
      };
      const double px = solid.centre_x_m({x, y});
      const double py = solid.centre_y_m({x, y});
      for (int k = 0; k < kRays; ++k) {
        const double angle = k * (6.283185307179586 / kRays);
        const double dx = std::cos(angle);
        const double dy = std::sin(angle);
        double hit = 1e9;
        walk_ray(solid, px, py, dx, dy, far_m, [&](std::size_t i, double at) {
          if (!solid.cells[i]) return true;
          hit = at;
          return false;
        });
        if (hit < near_m) continue;
        walk_ray(solid, px, py, dx, dy, far_m, [&](std::size_t i, double) {
          see(i);
          return !solid.cells[i];
        });
      }
    }
  }
  for (auto& c : count.cells) c = c >= 3;
  return count;
}

}  // namespace g3d::tests
