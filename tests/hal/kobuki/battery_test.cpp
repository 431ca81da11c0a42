// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/battery.hpp"

#include <catch2/catch.hpp>
#include <string>

namespace {

using namespace g3d::hal::kobuki;

void feed(Battery& battery, int decivolts, int packets, int charger = 0) {
  Feedback feedback;
  feedback.battery_decivolts = static_cast<std::uint8_t>(decivolts);
  feedback.charger = static_cast<std::uint8_t>(charger);
  for (int i = 0; i < packets; ++i) battery.update(feedback);
}

constexpr int kMinute = 3000;

TEST_CASE("the first reading counts in full") {
  Battery battery;
  CHECK(battery.voltage_v() == 0.0);
  feed(battery, 138, 1);
  CHECK(battery.voltage_v() == Approx(13.8));
  CHECK(battery.level() == BatteryLevel::low);
}

TEST_CASE("levels fall with the voltage") {
  Battery battery;
  feed(battery, 165, 1);
  CHECK(battery.level() == BatteryLevel::healthy);
  CHECK(battery.charge() == 1.0);
  feed(battery, 139, kMinute);
  CHECK(battery.level() == BatteryLevel::low);
  CHECK(battery.charge() > 0.0);
  feed(battery, 131, kMinute);
  CHECK(battery.level() == BatteryLevel::critical);
  CHECK(battery.charge() == 0.0);
}

TEST_CASE("a sag, or one wrong reading, is no empty battery") {
  Battery battery;
  feed(battery, 150, kMinute);
  feed(battery, 90, 1);
  CHECK(battery.level() == BatteryLevel::healthy);
  feed(battery, 125, 50);
  CHECK(battery.level() == BatteryLevel::healthy);
}

TEST_CASE("a level comes back only when it is clearly better") {
  Battery battery;
  feed(battery, 139, kMinute);
  CHECK(battery.level() == BatteryLevel::low);
  feed(battery, 142, kMinute);
  CHECK(battery.level() == BatteryLevel::low);
  feed(battery, 145, kMinute);
  CHECK(battery.level() == BatteryLevel::healthy);
  feed(battery, 142, kMinute);
  CHECK(battery.level() == BatteryLevel::healthy);
  feed(battery, 131, kMinute);
  feed(battery, 134, kMinute);
  CHECK(battery.level() == BatteryLevel::critical);
  feed(battery, 137, kMinute);
  CHECK(battery.level() == BatteryLevel::low);
}

TEST_CASE("where the power comes from") {
  struct Case {
    int charger;
    PowerSource source;
    bool is_charging;
  };
  for (const Case& c : {Case{0, PowerSource::battery, false}, Case{2, PowerSource::dock, false},
                        Case{6, PowerSource::dock, true}, Case{18, PowerSource::adapter, false},
                        Case{22, PowerSource::adapter, true}, Case{16, PowerSource::battery, false}}) {
    Battery battery;
    feed(battery, 160, 1, c.charger);
    CAPTURE(c.charger);
    CHECK(battery.source() == c.source);
    CHECK(battery.is_charging() == c.is_charging);
  }
}

TEST_CASE("levels have names") { CHECK(std::string(to_string(BatteryLevel::critical)) == "critical"); }

/// One reading a second is as good as fifty.
void drain(Battery& battery, double from_v, double to_v, int seconds, g3d::hal::TimeNs& now_ns) {
  Feedback feedback;
  for (int i = 0; i < seconds * 50; ++i) {
    const double volts = from_v + (to_v - from_v) * i / (seconds * 50);
    feedback.battery_decivolts = static_cast<std::uint8_t>(volts * 10.0 + 0.5);
    feedback.received_ns = now_ns += 20'000'000;
    battery.update(feedback);
  }
}

TEST_CASE("what is left goes by the life of a full one, until more is known") {
  Battery battery;
  CHECK(battery.left_s() > 1e9);
  g3d::hal::TimeNs now_ns = 0;
  drain(battery, 16.5, 16.5, 10, now_ns);
  CHECK(battery.left_s() == Approx(3.0 * 3600.0));
  drain(battery, 14.85, 14.85, 60, now_ns);  // half of the voltage between full and critical
  CHECK(battery.left_s() < 0.5 * 3.0 * 3600.0 + 60.0);
}

TEST_CASE("a battery that drains fast is empty soon, and about when it says") {
  Battery battery;
  g3d::hal::TimeNs now_ns = 0;
  drain(battery, 16.5, 14.85, 120, now_ns);
  CHECK(battery.left_s() == Approx(120.0).margin(20.0));
  drain(battery, 14.85, 13.4, 105, now_ns);
  CHECK(battery.left_s() == Approx(15.0).margin(12.0));
  drain(battery, 13.1, 13.1, 60, now_ns);
  CHECK(battery.left_s() == 0.0);
}

TEST_CASE("motors that start are no drain, and a charger ends the worry") {
  Battery battery;
  g3d::hal::TimeNs now_ns = 0;
  drain(battery, 16.2, 16.2, 20, now_ns);
  drain(battery, 15.8, 15.8, 8, now_ns);
  CHECK(battery.left_s() > 3600.0);
  Feedback charging;
  charging.battery_decivolts = 158;
  charging.charger = 22;
  charging.received_ns = now_ns += 20'000'000;
  battery.update(charging);
  CHECK(battery.left_s() > 1e9);
}

}  // namespace
