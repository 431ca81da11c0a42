// SPDX-License-Identifier: Apache-2.0
// From what arrives (flags in packets, stamps of commands and images, switches) to the conditions of safety.hpp. What
// must outlast its cause is remembered here, in one plain struct; all functions are pure but for that struct. A flag is
// taken from one packet and given up only after several that agree, so that one packet that slipped through its 8-bit
// checksum cannot clear it.
#pragma once

#include <cstdint>

#include "hal/messages.hpp"
#include "hal/safety.hpp"

namespace g3d::hal {

struct SafetyTimes {
  TimeNs silent_base_ns = 45'000'000;     ///< two packets missing, of one each 20 ms
  TimeNs stale_command_ns = 160'000'000;  ///< and the stop is sent within 20 ms after
  TimeNs silent_camera_ns = 350'000'000;  ///< three frames of a camera with 10 Hz
  TimeNs late_thread_ns = 60'000'000;     ///< between two ticks of 20 ms
  TimeNs late_base_ns = 80'000'000;       ///< older than the freshest feedback seen
  TimeNs wheels_up_ns = 1'000'000'000;    ///< both, before a dropped wheel is forgotten
  TimeNs over_current_ns = 500'000'000;   ///< standing, for the motor to cool
  TimeNs dead_wheel_ns = 1'000'000'000;   ///< standing, before wheels that did not count are tried again,
  std::uint32_t most_doublings = 5;       ///< and twice as long after every try in vain, so many times
  std::uint32_t agreeing_packets = 5;     ///< to clear a flag, and to believe in a base that was silent
  std::uint32_t agreeing_battery = 50;    ///< the voltage sags when the motors start
  std::uint32_t good_ticks = 5;           ///< after a late one
};

/// One packet's part in safety.
struct PacketFlags {
  bool bumper = false;
  bool cliff = false;
  bool wheel_drop = false;
  bool over_current = false;
  bool battery_low = false;
  bool battery_empty = false;
  bool dead_wheel = false;
  bool wheels_count = false;  ///< both wheels roll, and their encoders say so
  bool wrong_firmware = false;
  TimeNs age_ns = 0;  ///< how much later it came than the freshest ones do
};

/// A flag that holds until enough packets in a row were without it, and for at least some time.
struct HeldFlag {
  bool held = false;
  std::uint32_t quiet_packets = 0;
  TimeNs last_set_ns = 0;
  bool operator==(const HeldFlag&) const = default;
};

struct SafetyLatches {
  HeldFlag bumper, cliff, wheel_drop, over_current, battery_low, battery_empty, dead_wheel, wrong_firmware, late_base;
  std::uint32_t dead_wheel_tries = 0;  ///< in vain, one after the other
  bool had_packet = false;
  TimeNs last_packet_ns = 0;
  std::uint32_t packets_in_row = 0;  ///< without a silence between them
  bool had_command = false;
  TimeNs last_command_ns = 0;
  bool had_image = false;
  TimeNs last_image_ns = 0;
  bool e_stop_pressed = false;
  bool e_stop_latched = false;
  bool e_stop_awaited = false;
  bool rear_free = false;
  bool had_tick = false;
  TimeNs last_tick_ns = 0;
  std::uint32_t ticks_in_row = 0;  ///< in time
};

void note_packet(SafetyLatches& latches, const PacketFlags& flags, TimeNs received_ns, const SafetyTimes& times);
/// `stamp_ns` is when the command was decided; an older one than the last is ignored.
void note_command(SafetyLatches& latches, TimeNs stamp_ns);
/// The same for when an image was taken.
void note_image(SafetyLatches& latches, TimeNs stamp_ns);
/// The thread that runs the table says that it does.
void note_tick(SafetyLatches& latches, TimeNs now_ns, const SafetyTimes& times);
/// The switch. Pressed latches; released does nothing by itself.
void note_e_stop(SafetyLatches& latches, bool pressed);
/// A stop device that is wired up has not yet been seen well: it stands until then, and nobody needs to say resume.
void note_e_stop_awaited(SafetyLatches& latches, bool awaited);
/// A person says go on. Refused (false) while the switch is pressed.
[[nodiscard]] bool resume_after_e_stop(SafetyLatches& latches);

/// What is wrong at `now_ns`.
[[nodiscard]] Conditions conditions_at(const SafetyLatches& latches, TimeNs now_ns, const SafetyTimes& times);

}  // namespace g3d::hal
