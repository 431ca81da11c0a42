// SPDX-License-Identifier: Apache-2.0
#include "hal/safety_latches.hpp"

#include <algorithm>

namespace g3d::hal {
namespace {

void hold(HeldFlag& flag, bool set, TimeNs now_ns, std::uint32_t agreeing_packets, TimeNs at_least_ns = 0) {
  if (set) {
    flag = {true, 0, now_ns};
    return;
  }
  if (!flag.held) return;
  ++flag.quiet_packets;
  if (flag.quiet_packets >= agreeing_packets && now_ns - flag.last_set_ns >= at_least_ns) flag.held = false;
}

void note_stamp(bool& had, TimeNs& last_ns, TimeNs stamp_ns) {
  last_ns = had ? std::max(last_ns, stamp_ns) : stamp_ns;
  had = true;
}

// A stamp from farther ahead than it may be old comes from another clock: no proof of life either.
bool older(bool had, TimeNs last_ns, TimeNs now_ns, TimeNs limit_ns) {
  return !had || now_ns - last_ns > limit_ns || last_ns - now_ns > limit_ns;
}

}  // namespace

void note_packet(SafetyLatches& l, const PacketFlags& flags, TimeNs received_ns, const SafetyTimes& times) {
  const bool after_silence = older(l.had_packet, l.last_packet_ns, received_ns, times.silent_base_ns);
  l.packets_in_row = after_silence ? 1 : std::min(l.packets_in_row + 1, times.agreeing_packets);
  note_stamp(l.had_packet, l.last_packet_ns, received_ns);

  const std::uint32_t agree = times.agreeing_packets;
  // Time in which nothing was heard says nothing about the wheels: it does not count as time up.
  if (after_silence && l.wheel_drop.held) l.wheel_drop = {true, 0, received_ns};
  hold(l.wheel_drop, flags.wheel_drop, received_ns, agree, times.wheels_up_ns);
  hold(l.over_current, flags.over_current, received_ns, agree, times.over_current_ns);
  hold(l.bumper, flags.bumper, received_ns, agree);
  hold(l.cliff, flags.cliff, received_ns, agree);
  if (flags.dead_wheel && !l.dead_wheel.held)
    l.dead_wheel_tries = std::min(l.dead_wheel_tries + 1, times.most_doublings + 1);
  if (flags.wheels_count) l.dead_wheel_tries = 0;
  const std::uint32_t doublings = l.dead_wheel_tries > 0 ? l.dead_wheel_tries - 1 : 0;
  hold(l.dead_wheel, flags.dead_wheel, received_ns, agree, times.dead_wheel_ns << doublings);
  hold(l.wrong_firmware, flags.wrong_firmware, received_ns, agree);
  hold(l.late_base, flags.age_ns > times.late_base_ns, received_ns, agree);
  hold(l.battery_low, flags.battery_low, received_ns, times.agreeing_battery);
  hold(l.battery_empty, flags.battery_empty, received_ns, times.agreeing_battery);
}

void note_command(SafetyLatches& l, TimeNs stamp_ns) { note_stamp(l.had_command, l.last_command_ns, stamp_ns); }

void note_image(SafetyLatches& l, TimeNs stamp_ns) { note_stamp(l.had_image, l.last_image_ns, stamp_ns); }

void note_tick(SafetyLatches& l, TimeNs now_ns, const SafetyTimes& times) {
  const bool late = older(l.had_tick, l.last_tick_ns, now_ns, times.late_thread_ns);
  l.ticks_in_row = late ? 0 : std::min(l.ticks_in_row + 1, times.good_ticks);
  note_stamp(l.had_tick, l.last_tick_ns, now_ns);
}

void note_e_stop(SafetyLatches& l, bool pressed) {
  l.e_stop_pressed = pressed;
  if (pressed) l.e_stop_latched = true;
}

void note_e_stop_awaited(SafetyLatches& l, bool awaited) { l.e_stop_awaited = awaited; }

bool resume_after_e_stop(SafetyLatches& l) {
  if (l.e_stop_pressed) return false;
  l.e_stop_latched = false;
  return true;
}

Conditions conditions_at(const SafetyLatches& l, TimeNs now_ns, const SafetyTimes& times) {
  Conditions c;
  c.set(Condition::e_stop, l.e_stop_pressed || l.e_stop_latched || l.e_stop_awaited);
  c.set(Condition::wheel_drop, l.wheel_drop.held);
  c.set(Condition::silent_base, older(l.had_packet, l.last_packet_ns, now_ns, times.silent_base_ns) ||
                                    l.packets_in_row < times.agreeing_packets);
  c.set(Condition::late_base, l.late_base.held);
  c.set(Condition::late_thread,
        older(l.had_tick, l.last_tick_ns, now_ns, times.late_thread_ns) || l.ticks_in_row < times.good_ticks);
  c.set(Condition::stale_command, older(l.had_command, l.last_command_ns, now_ns, times.stale_command_ns));
  c.set(Condition::silent_camera, older(l.had_image, l.last_image_ns, now_ns, times.silent_camera_ns));
  c.set(Condition::wrong_firmware, l.wrong_firmware.held);
  c.set(Condition::battery_empty, l.battery_empty.held);
  c.set(Condition::dead_wheel, l.dead_wheel.held);
  c.set(Condition::over_current, l.over_current.held);
  c.set(Condition::cliff, l.cliff.held);
  c.set(Condition::bumper, l.bumper.held);
  c.set(Condition::rear_unknown, !l.rear_free);
  c.set(Condition::battery_low, l.battery_low.held);
  return c;
}

}  // namespace g3d::hal
