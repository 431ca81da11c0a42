// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/thermal_power.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

#include "hal/replay/decimal.hpp"

namespace g3d::hal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostSensors = 64;
constexpr int kMostChannels = 16;
constexpr double kMilli = 1e-3, kMicro = 1e-6;

std::string sensor_text(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.pop_back();
  return line;
}

std::optional<double> sensor_number(const std::string& path) {
  const auto value = parse_double(sensor_text(path));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

/// Sorted, so that the same machine says the same in the same order.
std::vector<std::string> sorted_entries(const std::string& folder, std::string_view prefix) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with(prefix)) found.push_back(at->path().string());
  }
  std::sort(found.begin(), found.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  return found;
}

std::string label_or(const std::string& path, const std::string& otherwise) {
  const std::string label = sensor_text(path);
  return label.empty() ? otherwise : label;
}

}  // namespace

ThermalPowerReader::ThermalPowerReader(std::string root) {
  find_zones(root);
  for (const std::string& folder : sorted_entries(root + "/class/hwmon", "hwmon")) find_hwmon(folder);
  find_l4t_rails(root);
}

void ThermalPowerReader::add(Sensor sensor) {
  if (sensors_.size() < kMostSensors && sensor_number(sensor.path)) sensors_.push_back(std::move(sensor));
}

void ThermalPowerReader::find_zones(const std::string& root) {
  for (const std::string& zone : sorted_entries(root + "/class/thermal", "thermal_zone")) {
    add({label_or(zone + "/type", fs::path(zone).filename().string()), false, kMilli, zone + "/temp", {}});
  }
}

void ThermalPowerReader::find_hwmon(const std::string& folder) {
  const std::string chip = label_or(folder + "/name", fs::path(folder).filename().string());
  for (int i = 1; i <= kMostChannels; ++i) {
    const auto file = [&](const char* kind, const char* what) {
      return fmt::format("{}/{}{}_{}", folder, kind, i, what);
    };
    const std::string plain = fmt::format("{} {}", chip, i);
    add({label_or(file("temp", "label"), plain), false, kMilli, file("temp", "input"), {}});
    add({label_or(file("power", "label"), plain), true, kMicro, file("power", "input"), {}});
    // Channels 1 to 3 are rails, 4 to 6 the shunts' voltages.
    if (chip != "ina3221" || i > 3 || !sensor_number(file("curr", "input"))) continue;
    add({label_or(file("in", "label"), plain), true, kMicro, file("in", "input"), file("curr", "input")});
  }
}

void ThermalPowerReader::find_l4t_rails(const std::string& root) {
  for (const std::string& chip : sorted_entries(root + "/bus/i2c/drivers/ina3221x", "")) {
    for (const std::string& device : sorted_entries(chip, "iio")) {
      for (int rail = 0; rail < 3; ++rail) {
        const std::string plain = fmt::format("{} {}", fs::path(chip).filename().string(), rail);
        add({label_or(fmt::format("{}/rail_name_{}", device, rail), plain),
             true,
             kMilli,
             fmt::format("{}/in_power{}_input", device, rail),
             {}});
      }
    }
  }
}

ThermalPower ThermalPowerReader::read() const {
  ThermalPower reading;
  for (const Sensor& sensor : sensors_) {
    auto value = sensor_number(sensor.path);
    if (value && !sensor.current_path.empty()) {
      const auto current = sensor_number(sensor.current_path);
      value = current ? std::optional(*value * *current) : std::nullopt;
    }
    if (!value) {
      ++reading.failed_reads;
    } else if (sensor.is_power) {
      reading.powers.push_back({sensor.name, *value * sensor.scale});
    } else {
      reading.temperatures.push_back({sensor.name, *value * sensor.scale});
    }
  }
  return reading;
}

double hottest_celsius(const ThermalPower& reading) {
  double hottest = 0.0;
  for (const Temperature& one : reading.temperatures) hottest = std::max(hottest, one.celsius);
  return hottest;
}

}  // namespace g3d::hal
