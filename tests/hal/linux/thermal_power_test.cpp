// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/thermal_power.hpp"

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;

namespace {

double watts_of(const ThermalPower& reading, const std::string& rail) {
  for (const Power& one : reading.powers) {
    if (one.rail == rail) return one.watts;
  }
  return -1.0;
}

}  // namespace

TEST_CASE("Thermal zones are read in degrees", "[thermal]") {
  const test::TempFolder sys;
  test::write_plain(sys / "class/thermal/thermal_zone0/type", "BCPU-therm\n");
  test::write_plain(sys / "class/thermal/thermal_zone0/temp", "47500\n");
  test::write_plain(sys / "class/thermal/thermal_zone10/type", "Tdiode_tegra\n");
  test::write_plain(sys / "class/thermal/thermal_zone10/temp", "-1250\n");
  test::write_plain(sys / "class/thermal/thermal_zone2/type", "broken\n");
  test::write_plain(sys / "class/thermal/thermal_zone2/temp", "warm\n");
  test::write_plain(sys / "class/thermal/cooling_device0/type", "pwm-fan\n");
  const ThermalPowerReader reader(sys.path());
  CHECK(reader.sensor_count() == 2);
  ThermalPower reading = reader.read();
  REQUIRE(reading.temperatures.size() == 2);
  CHECK(reading.temperatures[0].name == "BCPU-therm");
  CHECK(reading.temperatures[0].celsius == Approx(47.5));
  CHECK(reading.temperatures[1].celsius == Approx(-1.25));
  CHECK(hottest_celsius(reading) == Approx(47.5));
  std::filesystem::remove(sys / "class/thermal/thermal_zone0/temp");
  reading = reader.read();
  CHECK(reading.temperatures.size() == 1);
  CHECK(reading.failed_reads == 1);
}

TEST_CASE("An INA3221 is read as mainline and as L4T show it", "[thermal]") {
  const test::TempFolder sys;
  const std::string hwmon = "class/hwmon/hwmon3/";
  test::write_plain(sys / (hwmon + "name"), "ina3221\n");
  test::write_plain(sys / (hwmon + "in1_label"), "VDD_IN\n");
  test::write_plain(sys / (hwmon + "in1_input"), "19000\n");  // mV
  test::write_plain(sys / (hwmon + "curr1_input"), "500\n");  // mA
  test::write_plain(sys / (hwmon + "in4_input"), "7\n");      // a shunt's voltage
  test::write_plain(sys / "class/hwmon/hwmon4/name", "bmc\n");
  test::write_plain(sys / "class/hwmon/hwmon4/power1_input", "2500000\n");  // uW
  test::write_plain(sys / "class/hwmon/hwmon4/temp1_input", "30000\n");
  const std::string l4t = "bus/i2c/drivers/ina3221x/0-0041/iio:device1/";
  test::write_plain(sys / (l4t + "rail_name_0"), "VDD_SYS_CPU\n");
  test::write_plain(sys / (l4t + "in_power0_input"), "1530\n");  // mW
  const ThermalPower reading = ThermalPowerReader(sys.path()).read();
  CHECK(reading.powers.size() == 3);
  CHECK(watts_of(reading, "VDD_IN") == Approx(9.5));
  CHECK(watts_of(reading, "bmc 1") == Approx(2.5));
  CHECK(watts_of(reading, "VDD_SYS_CPU") == Approx(1.53));
  CHECK(reading.temperatures.size() == 1);
}

TEST_CASE("A machine without sensors has none", "[thermal]") {
  const ThermalPowerReader reader("/nonexistent");
  CHECK(reader.sensor_count() == 0);
  CHECK(reader.read().temperatures.empty());
  CHECK(hottest_celsius(reader.read()) == 0.0);
}
