// SPDX-License-Identifier: Apache-2.0
#include "tests/support/floor_plans.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "hal/image/pgm.hpp"
#include "hal/sim/map_world.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/temp_folder.hpp"

namespace g3d::tests {
namespace {

using nav::Cell;
using nav::CellGrid;
using nav::CellState;

template <typename T>
void fill_box(CellGrid<T>& grid, Cell low, Cell high, T value) {
  for (int y = std::max(low.y, 0); y <= std::min(high.y, grid.rows - 1); ++y) {
    for (int x = std::max(low.x, 0); x <= std::min(high.x, grid.columns - 1); ++x) grid.at({x, y}) = value;
  }
}

int between(Random& random, int low, int high) {
  return low + static_cast<int>(random.below(static_cast<std::uint32_t>(high - low + 1)));
}

void furnish(CellGrid<CellState>& floor, Random& random, Cell low, Cell high) {
  const int pieces = (high.x - low.x) * (high.y - low.y) / 1500;
  for (int i = 0; i < pieces; ++i) {
    const Cell at{between(random, low.x, high.x), between(random, low.y, high.y)};
    const Cell size{between(random, 1, 24), between(random, 1, 16)};
    fill_box(floor, at, {std::min(at.x + size.x, high.x), std::min(at.y + size.y, high.y)}, CellState::occupied);
  }
}

}  // namespace

CellGrid<CellState> random_floor(std::uint64_t seed, int columns, int rows) {
  Random random(seed);
  CellGrid<CellState> floor(0.05, -1.0, 2.0, columns, rows, CellState::free);
  const int things = columns * rows / 150;
  for (int i = 0; i < things; ++i) {
    const CellState state = random.below(3) == 0 ? CellState::unknown : CellState::occupied;
    const Cell at{between(random, 0, columns - 1), between(random, 0, rows - 1)};
    const bool is_bar = random.below(6) == 0;
    const Cell size{is_bar ? between(random, 0, columns / 3) : between(random, 0, 4), between(random, 0, 3)};
    fill_box(floor, at, {at.x + size.x, at.y + size.y}, state);
  }
  return floor;
}

CellGrid<CellState> office_floor(std::uint64_t seed, int side_cells) {
  Random random(seed);
  CellGrid<CellState> floor(0.05, 0.0, 0.0, side_cells, side_cells, CellState::occupied);
  constexpr int kCorridor_cells = 40, kWall_cells = 2;
  int previous_top = -1;
  for (int y = kWall_cells; y + kCorridor_cells < side_cells;) {
    fill_box(floor, {kWall_cells, y}, {side_cells - 1 - kWall_cells, y + kCorridor_cells - 1}, CellState::free);
    if (previous_top >= 0) {  // two ways from corridor to corridor, through the rooms between
      for (const int x : {side_cells / 7, side_cells * 6 / 7}) {
        fill_box(floor, {x, previous_top}, {x + 25, y}, CellState::free);
      }
    }
    const int depth = between(random, 60, 180);
    const int rooms_low = y + kCorridor_cells + kWall_cells;
    const int rooms_high = std::min(rooms_low + depth, side_cells - 1 - kWall_cells);
    for (int x = kWall_cells; x < side_cells - 60;) {
      const int right = std::min(x + between(random, 60, 180), side_cells - 1 - kWall_cells);
      fill_box(floor, {x, rooms_low}, {right, rooms_high}, CellState::free);
      furnish(floor, random, {x + 14, rooms_low + 14}, {right - 14, rooms_high - 14});
      const int door = between(random, x + 2, std::max(right - 26, x + 2));
      if (random.below(8) != 0) {
        fill_box(floor, {door, rooms_low - kWall_cells}, {door + between(random, 16, 24), rooms_low}, CellState::free);
      }
      if (random.below(3) == 0) {
        fill_box(floor, {right, rooms_low + 5}, {right + kWall_cells, rooms_low + 25}, CellState::free);
      }
      x = right + kWall_cells + 1;
    }
    previous_top = y + kCorridor_cells - 1;
    y = rooms_high + kWall_cells + 1;
  }
  return floor;
}

CellGrid<std::uint8_t> random_costs(std::uint64_t seed, int columns, int rows) {
  Random random(seed);
  CellGrid<std::uint8_t> costs(0.05, 0.0, 0.0, columns, rows, nav::kFreeCost);
  const int patches = 3 + columns * rows / 60;
  for (int i = 0; i < patches; ++i) {
    const std::uint32_t kind = random.below(4);
    const auto value = static_cast<std::uint8_t>(kind == 0 ? 253 + random.below(3) : random.below(253));
    const Cell at{between(random, 0, columns - 1), between(random, 0, rows - 1)};
    fill_box(costs, at, {at.x + between(random, 0, 6), at.y + between(random, 0, 6)}, value);
  }
  return costs;
}

std::optional<CellGrid<CellState>> mapped_floor(const std::string& yaml_path) {
  std::ifstream file(yaml_path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto yaml = hal::parse_map_yaml(text, yaml_path);
  if (!yaml) return std::nullopt;
  const auto image = hal::read_pgm((std::filesystem::path(yaml_path).parent_path() / yaml.value().image).string());
  if (!image) return std::nullopt;
  const int columns = static_cast<int>(image.value().size.width_px);
  const int rows = static_cast<int>(image.value().size.height_px);
  CellGrid<CellState> floor(yaml.value().resolution_m, yaml.value().origin_x_m, yaml.value().origin_y_m, columns, rows,
                            CellState::unknown);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const double grey =
          image.value().pixels[image.value().pixels.size() - static_cast<std::size_t>((y + 1) * columns) +
                               static_cast<std::size_t>(x)];
      const double occupied = (yaml.value().negate ? grey : 255.0 - grey) / 255.0;
      if (occupied > yaml.value().occupied_thresh) floor.at({x, y}) = CellState::occupied;
      if (occupied < yaml.value().free_thresh) floor.at({x, y}) = CellState::free;
    }
  }
  return floor;
}

std::vector<std::string> real_floor_plans() {
  std::vector<std::string> found;
  for (const char* folder : {"maps", "lidar2d"}) {
    const std::filesystem::path place = std::filesystem::path(test::data_folder()) / folder;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(place, error)) {
      if (entry.path().extension() == ".yaml") found.push_back(entry.path().string());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace g3d::tests
