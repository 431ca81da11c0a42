// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/calibration.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

// See board/board_file.cpp.
#define TOML_ASSERT(condition) static_assert(true)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include "hal/image/file_bytes.hpp"

namespace g3d::hal::kinect {
namespace {

constexpr std::size_t kMaxSerial_bytes = 64;

struct Number {
  std::string_view table;
  std::string_view key;
  double& (*of)(Calibration&);
  double low;
  double high;
};

// Ranges are what no sensible measurement leaves.
constexpr std::array kNumbers{
    Number{"colour", "fx_px", [](Calibration& c) -> double& { return c.colour.fx_px; }, 200, 2000},
    Number{"colour", "fy_px", [](Calibration& c) -> double& { return c.colour.fy_px; }, 200, 2000},
    Number{"colour", "cx_px", [](Calibration& c) -> double& { return c.colour.cx_px; }, 0, 639},
    Number{"colour", "cy_px", [](Calibration& c) -> double& { return c.colour.cy_px; }, 0, 479},
    Number{"infrared", "fx_px", [](Calibration& c) -> double& { return c.infrared.fx_px; }, 200, 2000},
    Number{"infrared", "fy_px", [](Calibration& c) -> double& { return c.infrared.fy_px; }, 200, 2000},
    Number{"infrared", "cx_px", [](Calibration& c) -> double& { return c.infrared.cx_px; }, 0, 639},
    Number{"infrared", "cy_px", [](Calibration& c) -> double& { return c.infrared.cy_px; }, 0, 479},
    Number{"infrared", "shift_x_px", [](Calibration& c) -> double& { return c.shift_x_px; }, -20, 20},
    Number{"infrared", "shift_y_px", [](Calibration& c) -> double& { return c.shift_y_px; }, -20, 20},
    Number{"colour_from_infrared", "x_m", [](Calibration& c) -> double& { return c.x_m; }, -0.2, 0.2},
    Number{"colour_from_infrared", "y_m", [](Calibration& c) -> double& { return c.y_m; }, -0.2, 0.2},
    Number{"colour_from_infrared", "z_m", [](Calibration& c) -> double& { return c.z_m; }, -0.2, 0.2},
    Number{"colour_from_infrared", "roll_deg", [](Calibration& c) -> double& { return c.roll_deg; }, -20, 20},
    Number{"colour_from_infrared", "pitch_deg", [](Calibration& c) -> double& { return c.pitch_deg; }, -20, 20},
    Number{"colour_from_infrared", "yaw_deg", [](Calibration& c) -> double& { return c.yaw_deg; }, -20, 20},
    Number{"depth", "offset_m", [](Calibration& c) -> double& { return c.depth_offset_m; }, -0.5, 0.5},
    Number{"depth", "scale", [](Calibration& c) -> double& { return c.depth_scale; }, 0.8, 1.2},
    Number{"depth", "quadratic_perm", [](Calibration& c) -> double& { return c.depth_quadratic_perm; }, -0.05, 0.05},
    Number{"time", "latency_ms", [](Calibration& c) -> double& { return c.latency_ms; }, 0, 200},
    Number{"accelerometer", "zero_x_g", [](Calibration& c) -> double& { return c.zero_x_g; }, -0.3, 0.3},
    Number{"accelerometer", "zero_y_g", [](Calibration& c) -> double& { return c.zero_y_g; }, -0.3, 0.3},
    Number{"accelerometer", "zero_z_g", [](Calibration& c) -> double& { return c.zero_z_g; }, -0.3, 0.3},
    Number{"accelerometer", "z_forward", [](Calibration& c) -> double& { return c.z_forward; }, -1, 1},
};

Error error_at(std::string_view name, const toml::source_region& where, Reason reason, std::string_view what) {
  return {reason, fmt::format("{}:{}: {}", name, where.begin.line, what)};
}

/// Plain ASCII alone, as in board files: toml++ 3.3 runs into undefined behaviour on some other characters.
Result<void> only_ascii(std::string_view text, std::string_view name) {
  std::size_t line = 1;
  for (const char c : text) {
    if (c == '\n') ++line;
    if ((c >= 0x20 && c < 0x7F) || c == '\n' || c == '\r' || c == '\t') continue;
    return Error{Reason::malformed, fmt::format("{}:{}: byte 0x{:02X}; a calibration file is plain ASCII", name, line,
                                                static_cast<unsigned char>(c))};
  }
  return {};
}

std::string known_keys(std::string_view table) {
  std::string known;
  std::string_view last;
  for (const Number& number : kNumbers) {
    if (number.table == table) known += fmt::format(" {}", number.key);
    if (table.empty() && number.table != last) known += fmt::format(" [{}]", number.table);
    last = number.table;
  }
  return table.empty() ? " serial" + known : known;
}

Result<void> read_number(std::string_view table, const toml::key& key, const toml::node& node, std::string_view name,
                         Calibration& into) {
  for (const Number& number : kNumbers) {
    if (number.table != table || number.key != key.str()) continue;
    if (!node.is_number()) {
      return error_at(name, node.source(), Reason::malformed,
                      fmt::format("{}.{} must be a number from {} to {}", table, number.key, number.low, number.high));
    }
    const double value = node.value<double>().value_or(0.0);
    if (!(value >= number.low && value <= number.high)) {  // NaN too
      return error_at(
          name, node.source(), Reason::out_of_range,
          fmt::format("{}.{} is {}, allowed are {} to {}", table, number.key, value, number.low, number.high));
    }
    number.of(into) = value;
    return {};
  }
  return error_at(name, key.source(), Reason::malformed,
                  fmt::format("{}.{} is not known; here are{}", table, key.str().substr(0, 40), known_keys(table)));
}

Result<void> read_entry(const toml::key& key, const toml::node& node, std::string_view name, Calibration& into) {
  if (key.str() == "serial") {
    const auto text = node.value_exact<std::string>();
    if (!text || text->size() > kMaxSerial_bytes || text->find_first_of("\"\\\n\r\t") != std::string::npos) {
      return error_at(name, node.source(), Reason::malformed, "serial must be a text in quotes of at most 64 bytes");
    }
    into.serial = *text;
    return {};
  }
  const toml::table* const table = node.as_table();
  bool is_known = false;
  for (const Number& number : kNumbers) is_known = is_known || number.table == key.str();
  if (table == nullptr || !is_known) {
    return error_at(name, key.source(), Reason::malformed,
                    fmt::format("{} is not known; here are{}", key.str().substr(0, 40), known_keys("")));
  }
  for (const auto& [inner_key, inner] : *table) {
    if (auto read = read_number(key.str(), inner_key, inner, name, into); !read) return read;
  }
  return {};
}

CameraModel model_of(const Intrinsics& intrinsics) {
  CameraModel model;
  model.fx_px = static_cast<float>(intrinsics.fx_px);
  model.fy_px = static_cast<float>(intrinsics.fy_px);
  model.cx_px = static_cast<float>(intrinsics.cx_px);
  model.cy_px = static_cast<float>(intrinsics.cy_px);
  return model;
}

}  // namespace

Result<Calibration> parse_calibration(std::string_view text, std::string_view name) {
  if (text.size() > kMaxCalibration_bytes) {
    return Error{Reason::too_large, fmt::format("{}: {} bytes are too many for a calibration file", name, text.size())};
  }
  if (auto checked = only_ascii(text, name); !checked) return checked.error();
  const toml::parse_result parsed = toml::parse(text);
  if (!parsed) return error_at(name, parsed.error().source(), Reason::malformed, parsed.error().description());
  Calibration calibration;
  for (const auto& [key, node] : parsed.table()) {
    if (auto read = read_entry(key, node, name, calibration); !read) return read.error();
  }
  if (std::abs(calibration.z_forward) != 1.0) {
    return Error{Reason::out_of_range, fmt::format("{}: accelerometer.z_forward must be 1 or -1", name)};
  }
  return calibration;
}

Result<Calibration> load_calibration(const std::string& path) {
  auto text = read_text_file(path, kMaxCalibration_bytes);
  if (!text) return text.error();
  return parse_calibration(text.value(), path);
}

std::string calibration_text(const Calibration& calibration) {
  Calibration copy = calibration;
  std::string text = fmt::format("serial = \"{}\"\n", copy.serial);
  std::string_view table;
  for (const Number& number : kNumbers) {
    if (number.table != table) text += fmt::format("\n[{}]\n", number.table);
    table = number.table;
    // A point always: toml++ takes whole numbers too, people wonder about them.
    text += fmt::format("{} = {:#}\n", number.key, number.of(copy));
  }
  return text;
}

CameraModel colour_model(const Calibration& calibration) { return model_of(calibration.colour); }

CameraModel infrared_model(const Calibration& calibration) {
  Intrinsics shifted = calibration.infrared;
  shifted.cx_px += calibration.shift_x_px;
  shifted.cy_px += calibration.shift_y_px;
  return model_of(shifted);
}

}  // namespace g3d::hal::kinect
