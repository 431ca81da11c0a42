// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/map_world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "hal/image/file_bytes.hpp"
#include "hal/sim/map_crop.hpp"
#include "hal/sim/map_start.hpp"
#include "hal/sim/text_fields.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kMaxYamlBytes = 64U << 10;
constexpr double kSlab_m = 0.2;

enum class Cell : std::uint8_t { free, occupied, unknown };

std::string_view without_blanks(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '\r')) s.remove_suffix(1);
  return s;
}

/// Value without a comment behind it and without quotes around it.
std::string_view plain_value(std::string_view s) {
  s = without_blanks(s);
  if (s.size() >= 2 && (s.front() == '"' || s.front() == '\'')) {
    const std::size_t close = s.find(s.front(), 1);
    return close == std::string_view::npos ? s : s.substr(1, close - 1);
  }
  const std::size_t comment = s.find(" #");
  return without_blanks(s.substr(0, comment));
}

Result<double> read_number(const TextLine& line, std::string_view name, std::string_view word, double low,
                           double high) {
  return line.number_in(plain_value(word), name, low, high);
}

/// `[x, y, yaw]`
Result<void> read_origin(const TextLine& line, std::string_view value, MapYaml& yaml) {
  if (value.size() < 2 || value.front() != '[' || value.back() != ']') {
    return line.error(Reason::malformed, "origin is written as [x, y, yaw]");
  }
  value = value.substr(1, value.size() - 2);
  double numbers[3] = {};
  constexpr std::string_view kNames[3] = {"origin x", "origin y", "origin yaw"};
  for (int i = 0; i < 3; ++i) {
    const std::size_t comma = value.find(',');
    if ((comma == std::string_view::npos) != (i == 2)) {
      return line.error(Reason::malformed, "origin needs three numbers: [x, y, yaw]");
    }
    const auto number = read_number(line, kNames[i], value.substr(0, comma), -kMaxCoordinate_m, kMaxCoordinate_m);
    if (!number) return number.error();
    numbers[i] = number.value();
    value.remove_prefix(i == 2 ? value.size() : comma + 1);
  }
  if (numbers[2] < -1e-6 || numbers[2] > 1e-6) {
    return line.error(Reason::unsupported,
                      "a turned map (yaw other than 0) is not supported; turn the picture instead");
  }
  yaml.origin_x_m = numbers[0];
  yaml.origin_y_m = numbers[1];
  return {};
}

Result<void> read_key(const TextLine& line, std::string_view key, std::string_view value, MapYaml& yaml) {
  const auto into = [&](double& target, double low, double high) -> Result<void> {
    const auto number = read_number(line, key, value, low, high);
    if (!number) return number.error();
    target = number.value();
    return {};
  };
  if (key == "image") {
    yaml.image = std::string(value);
    return {};
  }
  if (key == "resolution") return into(yaml.resolution_m, 0.001, 10.0);
  if (key == "origin") return read_origin(line, value, yaml);
  if (key == "occupied_thresh") return into(yaml.occupied_thresh, 0.0, 1.0);
  if (key == "free_thresh") return into(yaml.free_thresh, 0.0, 1.0);
  if (key == "negate") {
    if (value != "0" && value != "1" && value != "true" && value != "false") {
      return line.error(Reason::malformed, fmt::format("negate is 0 or 1, not '{}'", value.substr(0, 40)));
    }
    yaml.negate = value == "1" || value == "true";
  }
  return {};
}

/// Classified cells with a border of unknown ones, row-major from the lowest y.
std::vector<Cell> classify(const MapYaml& yaml, const GreyImage& image, int width, int height) {
  std::vector<Cell> cells(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), Cell::unknown);
  const int columns = image.size.width_px;
  const int rows = image.size.height_px;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::uint8_t grey = image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                                             static_cast<std::size_t>(column)];
      const double white = static_cast<double>(grey) / image.max_value;
      const double occupied = yaml.negate ? white : 1.0 - white;
      const std::size_t cell =
          static_cast<std::size_t>(rows - row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column) + 1;
      if (occupied > yaml.occupied_thresh) {
        cells[cell] = Cell::occupied;
      } else if (occupied < yaml.free_thresh) {
        cells[cell] = Cell::free;
      }
    }
  }
  return cells;
}

bool touches_free(const std::vector<Cell>& cells, int width, int height, int i, int j) {
  for (int y = std::max(j - 1, 0); y <= std::min(j + 1, height - 1); ++y) {
    for (int x = std::max(i - 1, 0); x <= std::min(i + 1, width - 1); ++x) {
      if (cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] ==
          Cell::free) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

Result<MapYaml> parse_map_yaml(std::string_view text, std::string_view file) {
  if (text.size() > kMaxYamlBytes) {
    return Error{Reason::too_large, fmt::format("{}: {} bytes are too many for a map's yaml file", file, text.size())};
  }
  MapYaml yaml;
  bool has_resolution = false;
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = text.find('\n');
    const std::string_view content = without_blanks(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (content.empty() || content.front() == '#' || content == "---") continue;
    const TextLine line(file, number, {});
    const std::size_t colon = content.find(':');
    if (colon == std::string_view::npos) return line.error(Reason::malformed, "expected `key: value`");
    const std::string_view key = without_blanks(content.substr(0, colon));
    if (auto read = read_key(line, key, plain_value(content.substr(colon + 1)), yaml); !read) return read.error();
    has_resolution = has_resolution || key == "resolution";
  }
  if (yaml.image.empty()) return Error{Reason::malformed, fmt::format("{}: no line `image: FILE.pgm`", file)};
  if (!has_resolution) return Error{Reason::malformed, fmt::format("{}: no line `resolution: METRES`", file)};
  if (yaml.free_thresh > yaml.occupied_thresh) {
    return Error{Reason::malformed, fmt::format("{}: free_thresh is above occupied_thresh", file)};
  }
  return yaml;
}

Result<World> make_map_world(const MapYaml& yaml, const GreyImage& image, const MapWorldOptions& options,
                             std::string_view file) {
  const int width = image.size.width_px + 2;
  const int height = image.size.height_px + 2;
  const double r = yaml.resolution_m;
  const double low_x = yaml.origin_x_m - r;
  const double low_y = yaml.origin_y_m - r;
  const double size_x = width * r;
  const double size_y = height * r;
  if (low_x + size_x > 2 * kMaxCoordinate_m || low_y + size_y > 2 * kMaxCoordinate_m) {
    return Error{Reason::out_of_range, fmt::format("{}: the map reaches beyond {} m", file, 2 * kMaxCoordinate_m)};
  }
  const std::vector<Cell> cells = classify(yaml, image, width, height);
  std::vector<std::uint8_t> solid(cells.size());
  std::vector<std::uint8_t> is_free(cells.size());
  bool has_free = false;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const std::size_t cell =
          static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i);
      is_free[cell] = cells[cell] == Cell::free ? 1 : 0;
      has_free = has_free || cells[cell] == Cell::free;
      solid[cell] =
          cells[cell] == Cell::occupied || (cells[cell] == Cell::unknown && touches_free(cells, width, height, i, j));
    }
  }
  if (!has_free) {
    return Error{Reason::malformed, fmt::format("{}: no free cell in the picture; see negate and free_thresh", file)};
  }
  World world;
  Material floor;
  floor.colour = {168, 150, 128};
  floor.second_colour = {150, 134, 116};
  floor.texture = Texture::checker;
  floor.texture_size_m = 0.6F;
  const double middle_x = low_x + size_x / 2;
  const double middle_y = low_y + size_y / 2;
  world.add_floor({middle_x, middle_y, 0.0}, size_x, size_y, kSlab_m, floor);
  if (options.ceiling) {
    Material ceiling;
    ceiling.colour = {226, 226, 220};
    world.add_box({middle_x, middle_y, options.wall_height_m}, {size_x, size_y, kSlab_m}, 0.0, ceiling);
  }
  world.set_grid(GridWalls(width, height, static_cast<float>(r), {static_cast<float>(low_x), static_cast<float>(low_y)},
                           0.0F, static_cast<float>(options.wall_height_m), solid));
  if (const auto start = widest_start(*world.grid(), is_free)) world.add_start(*start);
  return world;
}

Result<World> load_map_world(const std::string& yaml_path, const MapWorldOptions& options,
                             const std::optional<FloorRectangle>& crop) {
  const auto text = read_text_file(yaml_path, kMaxYamlBytes);
  if (!text) return text.error();
  auto yaml = parse_map_yaml(text.value(), yaml_path);
  if (!yaml) return yaml.error();
  const std::string& image = yaml.value().image;
  const std::size_t slash = yaml_path.rfind('/');
  const bool beside = image.front() != '/' && slash != std::string::npos;
  const std::string image_path = beside ? yaml_path.substr(0, slash + 1) + image : image;
  auto picture = read_pgm(image_path);
  if (!picture) return picture.error();
  if (crop) {
    if (const auto cut = crop_map(yaml.value(), picture.value(), *crop, yaml_path); !cut) return cut.error();
  }
  return make_map_world(yaml.value(), picture.value(), options, yaml_path);
}

}  // namespace g3d::hal
