// SPDX-License-Identifier: Apache-2.0
// How warm the machine is and what it draws, from the files of /sys:
//
//   class/thermal/thermal_zoneN/{type,temp}                      millidegrees, everywhere
//   class/hwmon/hwmonN/{name,tempM_label,tempM_input}            millidegrees
//   class/hwmon/hwmonN/powerM_{label,input}                      microwatts
//   class/hwmon/hwmonN/{inM_label,inM_input,currM_input}         mV and mA of an INA3221, mainline's driver
//   bus/i2c/drivers/ina3221x/ADDRESS/iio:deviceN/{rail_name_K,in_powerK_input}   milliwatts, L4T r32's driver, e.g. TX2
#pragma once

#include <string>
#include <vector>

#include "hal/result.hpp"

namespace g3d::hal {

struct Temperature {
  std::string name;
  double celsius = 0.0;
};
struct Power {
  std::string rail;
  double watts = 0.0;
};
struct ThermalPower {
  std::vector<Temperature> temperatures;
  std::vector<Power> powers;
  std::uint64_t failed_reads = 0;  ///< files that were there at the start and gave no number, in this reading
};

/// Finds the files once; then reads those.
class ThermalPowerReader {
 public:
  /// `root`: "/sys", or a test's.
  explicit ThermalPowerReader(std::string root = "/sys");
  /// Any one thread that may wait: some of these files ask a chip on a slow bus.
  [[nodiscard]] ThermalPower read() const;
  [[nodiscard]] std::size_t sensor_count() const { return sensors_.size(); }

 private:
  struct Sensor {
    std::string name;
    bool is_power = false;
    double scale = 1.0;  ///< of the file's number to degrees or watts
    std::string path;
    std::string current_path;  ///< not empty: its number is a factor too
  };
  void find_zones(const std::string& root);
  void find_hwmon(const std::string& folder);
  void find_l4t_rails(const std::string& root);
  void add(Sensor sensor);

  std::vector<Sensor> sensors_;
};

/// The hottest; 0 if there is none.
[[nodiscard]] double hottest_celsius(const ThermalPower& reading);

}  // namespace g3d::hal
