// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/world_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>

#include "hal/sim/text_fields.hpp"

namespace g3d::hal {
namespace {

constexpr double kMaxSteps = 200;
constexpr double kMaxBoards = 50;
constexpr double kMaxPoleRadius_m = 0.1;

/// What one number of a line may be.
struct FieldRange {
  std::string_view name;
  double low;
  double high;
};
constexpr FieldRange kX{"x", -kMaxCoordinate_m, kMaxCoordinate_m};
constexpr FieldRange kY{"y", -kMaxCoordinate_m, kMaxCoordinate_m};
constexpr FieldRange kZ{"z", -kMaxCoordinate_m, kMaxCoordinate_m};
constexpr FieldRange kYawField{"yaw", -3600.0, 3600.0};
constexpr FieldRange size(std::string_view name) { return {name, kMinSize_m, kMaxCoordinate_m}; }

struct Kind {
  std::string_view word;
  std::vector<FieldRange> numbers;
  std::size_t optional;  ///< how many of the last ones may be left out
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> table = {
      {"box", {kX, kY, kZ, size("size_x"), size("size_y"), size("size_z"), kYawField}, 1},
      {"sphere", {kX, kY, kZ, size("radius")}, 0},
      {"cylinder", {kX, kY, kZ, size("radius"), size("height")}, 0},
      {"pole", {kX, kY, kZ, {"radius", kMinSize_m, kMaxPoleRadius_m}, size("height")}, 0},
      {"cone", {kX, kY, kZ, size("radius"), size("height"), {"top_radius", 0.0, kMaxCoordinate_m}}, 1},
      {"stairs", {kX, kY, kZ, size("width"), size("run"), size("rise"), {"steps", 1, kMaxSteps}, kYawField}, 1},
      {"shelves",
       {kX,
        kY,
        kZ,
        {"width", 0.05, kMaxCoordinate_m},
        size("depth"),
        {"height", 0.05, kMaxCoordinate_m},
        {"boards", 2, kMaxBoards},
        kYawField},
       1},
      {"floor", {kX, kY, kZ, size("size_x"), size("size_y"), size("thickness")}, 0},
      {"room", {kX, kY, kZ, size("size_x"), size("size_y"), size("size_z"), size("thickness")}, 0},
      {"person", {{"height", 0.2, 3.0}, {"radius", 0.05, 1.0}}, 0},
      {"start", {kX, kY, {"heading", -3600.0, 3600.0}}, 0},
  };
  return table;
}

struct Options {
  Material material;
  Material floor;
  Material ceiling;
  bool open = false;
};

std::optional<Rgb> parse_colour(std::string_view word) {
  if (word.size() != 7 || word[0] != '#') return std::nullopt;
  std::uint32_t value = 0;
  for (const char c : word.substr(1)) {
    std::uint32_t digit = 0;
    if (c >= '0' && c <= '9') {
      digit = static_cast<std::uint32_t>(c - '0');
    } else if ((c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F')) {
      digit = static_cast<std::uint32_t>((c | 0x20) - 'a') + 10;
    } else {
      return std::nullopt;
    }
    value = value * 16 + digit;
  }
  return Rgb{static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
             static_cast<std::uint8_t>(value)};
}

Result<void> read_texture(const TextLine& line, std::string_view value, Material& material) {
  const std::size_t colon = value.find(':');
  const std::string_view name = value.substr(0, colon);
  if (name == "checker") {
    material.texture = Texture::checker;
  } else if (name == "stripes") {
    material.texture = Texture::stripes;
  } else {
    return line.error(Reason::malformed, "texture is checker:METRES or stripes:METRES");
  }
  const std::string_view size_word = colon == std::string_view::npos ? std::string_view{} : value.substr(colon + 1);
  const auto size_m = line.number_in(size_word, "texture size", 0.005, 100.0);
  if (!size_m) return size_m.error();
  material.texture_size_m = static_cast<float>(size_m.value());
  return {};
}

Result<void> read_option(const TextLine& line, std::string_view word, bool is_room, Options& options) {
  if (word == "dark") {
    options.material.dark = true;
    return {};
  }
  if (word == "glass") {
    options.material.glass = true;
    return {};
  }
  if (word == "open" && is_room) {
    options.open = true;
    return {};
  }
  const std::size_t equals = word.find('=');
  const std::string_view key = word.substr(0, equals);
  const std::string_view value = equals == std::string_view::npos ? std::string_view{} : word.substr(equals + 1);
  if (key == "texture") return read_texture(line, value, options.material);
  Rgb* target = nullptr;
  if (key == "color") target = &options.material.colour;
  if (key == "color2") target = &options.material.second_colour;
  if (is_room && key == "floor") target = &options.floor.colour;
  if (is_room && key == "ceiling") target = &options.ceiling.colour;
  if (is_room && key == "floor2") {
    target = &options.floor.second_colour;
    options.floor.texture = Texture::checker;
  }
  if (target == nullptr) {
    return line.error(Reason::malformed,
                      fmt::format("'{}' is not known here; color=#rrggbb, color2=, texture=, dark and glass are{}",
                                  word.substr(0, 40), is_room ? ", and floor=, floor2=, ceiling= and open" : ""));
  }
  const auto colour = parse_colour(value);
  if (!colour)
    return line.error(Reason::malformed, fmt::format("'{}' is not a colour like #a0b1c2", value.substr(0, 40)));
  *target = *colour;
  return {};
}

Result<Mover> read_waypoints(const TextLine& line, std::span<const std::string_view> words) {
  Mover mover;
  for (const std::string_view word : words) {
    const std::size_t first = word.find(',');
    const std::size_t second = first == std::string_view::npos ? first : word.find(',', first + 1);
    if (second == std::string_view::npos) return line.error(Reason::malformed, "a waypoint is t,x,y without blanks");
    const auto t = line.number_in(word.substr(0, first), "t", 0.0, 1e6);
    if (!t) return t.error();
    const auto x = line.number_in(word.substr(first + 1, second - first - 1), "x", kX.low, kX.high);
    if (!x) return x.error();
    const auto y = line.number_in(word.substr(second + 1), "y", kY.low, kY.high);
    if (!y) return y.error();
    if (!mover.waypoints.empty() && t.value() <= mover.waypoints.back().t_s) {
      return line.error(Reason::malformed, "the times of the waypoints must ascend");
    }
    if (mover.waypoints.size() == kMaxMoverWaypoints) {
      return line.error(Reason::too_large, fmt::format("more than {} waypoints", kMaxMoverWaypoints));
    }
    mover.waypoints.push_back({t.value(), x.value(), y.value()});
  }
  if (mover.waypoints.empty()) return line.error(Reason::malformed, "a person needs at least one waypoint t,x,y");
  return mover;
}

/// Precondition: `n` holds all numbers of the kind, within their ranges.
void add_solid(World& world, std::string_view kind, const std::vector<double>& n, const Options& options) {
  const Material& material = options.material;
  const auto count = [](double x) { return static_cast<int>(x); };
  if (kind == "box") world.add_box({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], material);
  if (kind == "sphere") world.add_sphere({n[0], n[1], n[2]}, n[3], material);
  if (kind == "cylinder" || kind == "pole") world.add_cylinder({n[0], n[1], n[2]}, n[3], n[4], material);
  if (kind == "cone") world.add_cone({n[0], n[1], n[2]}, n[3], n[4], n[5], material);
  if (kind == "stairs") world.add_stairs({n[0], n[1], n[2]}, n[3], n[4], n[5], count(n[6]), n[7], material);
  if (kind == "shelves") world.add_shelves({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, count(n[6]), n[7], material);
  if (kind == "floor") world.add_floor({n[0], n[1], n[2]}, n[3], n[4], n[5], material);
  if (kind == "room") {
    const std::optional<Material> ceiling = options.open ? std::nullopt : std::optional<Material>(options.ceiling);
    world.add_room({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], material, options.floor, ceiling);
  }
}

/// Precondition: `n` holds x, y and heading in degrees; `read` words of the line are used up.
Result<void> read_start(const TextLine& line, const std::vector<double>& n, std::size_t read, World& world) {
  if (read != line.words().size()) return line.error(Reason::malformed, "start takes x y heading and nothing else");
  if (world.starts().size() == kMaxStarts) {
    return line.error(Reason::too_large, fmt::format("more than {} starts", kMaxStarts));
  }
  const double turns = n[2] / 360.0;
  double rest = turns - static_cast<double>(static_cast<int>(turns));
  if (rest > 0.5) rest -= 1.0;
  if (rest <= -0.5) rest += 1.0;
  world.add_start({n[0], n[1], rest * 2.0 * std::numbers::pi});
  return {};
}

Result<void> read_solid(const TextLine& line, World& world) {
  const std::span<const std::string_view> words = line.words();
  const auto kind = std::find_if(kinds().begin(), kinds().end(), [&](const Kind& k) { return k.word == words[0]; });
  if (kind == kinds().end()) {
    return line.error(Reason::malformed,
                      fmt::format("'{}' is not known; box, sphere, cylinder, pole, cone, stairs, shelves, floor, "
                                  "room, person and start are",
                                  words[0].substr(0, 40)));
  }
  std::size_t next = 1;
  std::vector<double> numbers;
  for (const FieldRange& range : kind->numbers) {
    if (next == words.size() || !parse_number(words[next])) break;
    const auto value = line.number_in(words[next], range.name, range.low, range.high);
    if (!value) return value.error();
    numbers.push_back(value.value());
    ++next;
  }
  if (numbers.size() + kind->optional < kind->numbers.size()) {
    return line.error(Reason::malformed,
                      fmt::format("{} needs a number for {} here", kind->word, kind->numbers[numbers.size()].name));
  }
  numbers.resize(kind->numbers.size(), 0.0);

  std::size_t options_from = next;
  if (kind->word == "person") {
    while (options_from < words.size() && words[options_from].find(',') != std::string_view::npos) ++options_from;
  }
  if (kind->word == "start") return read_start(line, numbers, next, world);
  Options options;
  for (const std::string_view word : words.subspan(options_from)) {
    if (auto read = read_option(line, word, kind->word == "room", options); !read) return read;
  }
  if (kind->word == "person") {
    auto mover = read_waypoints(line, words.subspan(next, options_from - next));
    if (!mover) return mover.error();
    if (world.movers().size() == kMaxMovers) {
      return line.error(Reason::too_large, fmt::format("more than {} persons", kMaxMovers));
    }
    world.add_person(numbers[0], numbers[1], options.material, std::move(mover).value());
  }
  add_solid(world, kind->word, numbers, options);
  if (world.primitives().size() > kMaxPrimitives) {
    return line.error(Reason::too_large,
                      fmt::format("more than {} solids (stairs and shelves count per step and board)", kMaxPrimitives));
  }
  return {};
}

}  // namespace

Result<World> parse_world(std::string_view text, std::string_view file) {
  const auto lines = split_lines(text, file);
  if (!lines) return lines.error();
  World world;
  for (const TextLine& line : lines.value()) {
    if (auto read = read_solid(line, world); !read) return read.error();
  }
  if (world.primitives().empty()) {
    return Error{Reason::malformed, fmt::format("{}: no solid in it; one per line, like: box 1 0 0 0.5 0.5 1", file)};
  }
  return world;
}

}  // namespace g3d::hal
