// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/base_driver.hpp"

#include <cmath>
#include <cstdlib>

namespace g3d::hal::kobuki {
namespace {

constexpr TimeNs kAskAgain_ns = 500 * kMillisecond_ns;
constexpr TimeNs kRepeatOutputs_ns = 1'000 * kMillisecond_ns;  // a lost frame must not leave the LEDs wrong
constexpr std::uint8_t kFirmwareMajor = 1;

bool is_still(const Twist& twist) { return twist.forward_mps == 0.0 && twist.turn_radps == 0.0; }

/// Sides add up while the flag holds, so that a contact that wanders is marked as wide as it was.
void collect(std::uint8_t& sides, std::uint8_t now, bool held) { sides = held ? sides | now : 0; }

}  // namespace

BaseDriver::BaseDriver(const BaseDriverOptions& options)
    : options_(options), battery_(options.battery), limits_(options.limits) {
  judge_now(0);
}

void BaseDriver::on_bytes(std::span<const std::uint8_t> bytes, TimeNs received_ns) {
  state_.received_bytes += bytes.size();
  reader_.feed(bytes, received_ns, [this](const Feedback& feedback) { on_feedback(feedback); });
}

void BaseDriver::on_feedback(const Feedback& feedback) {
  ++state_.packets;
  state_.feedback_ns = feedback.received_ns;
  state_.buttons = feedback.buttons;
  state_.dock_ir = feedback.dock_ir;
  odometry_.update(feedback);
  battery_.update(feedback);
  trail_.update(odometry_.T_world_base());
  // Packets that were held up come all at once: each tells of a moment before that.
  const TimeNs age_ns = link_delay_.update(feedback);
  poses_.add(feedback.received_ns - age_ns, odometry_.T_world_base());

  PacketFlags flags;
  flags.bumper = feedback.bumper != 0;
  flags.cliff = feedback.cliff != 0;
  flags.wheel_drop = feedback.wheel_drop != 0;
  flags.over_current = feedback.over_current != 0;
  flags.battery_low = battery_.level() != BatteryLevel::healthy;
  flags.battery_empty = battery_.level() == BatteryLevel::critical;
  flags.dead_wheel = odometry_.wheel_is_dead() || odometry_.is_stalled();
  flags.wheels_count = !flags.dead_wheel && odometry_.are_both_rolling();
  flags.wrong_firmware = reader_.info().has_firmware && reader_.info().firmware[0] != kFirmwareMajor;
  flags.age_ns = age_ns;
  note_packet(latches_, flags, feedback.received_ns, options_.times);
  if (flags.wheel_drop) trail_.forget();  // lifted: it may be set down anywhere

  collect(bumper_sides_, feedback.bumper, latches_.bumper.held);
  collect(cliff_sides_, feedback.cliff, latches_.cliff.held);
  collect(wheel_sides_, feedback.wheel_drop, latches_.wheel_drop.held);
}

void BaseDriver::on_line_lost() {
  reader_.line_was_lost();
  latches_.packets_in_row = 0;
}

void BaseDriver::set_command(const Twist& wanted, TimeNs stamp_ns) {
  if (latches_.had_command && stamp_ns < wanted_ns_) return;
  if (!std::isfinite(wanted.forward_mps) || !std::isfinite(wanted.turn_radps)) {
    ++state_.refused_wishes;
    wanted_ = {};
  } else {
    wanted_ = wanted;
  }
  wanted_ns_ = stamp_ns;
  note_command(latches_, stamp_ns);
}

void BaseDriver::set_camera_alive(TimeNs stamp_ns) { note_image(latches_, stamp_ns); }

void BaseDriver::set_rear_free(TimeNs stamp_ns) {
  rear_was_told_ = true;
  rear_told_ns_ = stamp_ns;
}

void BaseDriver::set_e_stop(bool pressed) { note_e_stop(latches_, pressed); }

void BaseDriver::set_e_stop_awaited(bool awaited) { note_e_stop_awaited(latches_, awaited); }

bool BaseDriver::resume() { return resume_after_e_stop(latches_); }

void BaseDriver::judge_now(TimeNs now_ns) {
  const bool told = rear_was_told_ && std::abs(now_ns - rear_told_ns_) <= options_.rear_free_ns;
  latches_.rear_free = told || trail_.leads_back_from(odometry_.T_world_base());

  const Conditions before = state_.conditions;
  state_.conditions = conditions_at(latches_, now_ns, options_.times);
  state_.verdict = judge(state_.conditions);
  state_.was_ready |= state_.verdict.allowance.forward_mps > 0.0;
  if (state_.was_ready && state_.verdict.reason != Condition::count_) {
    state_.last_reason = state_.verdict.reason;
    state_.last_reason_ns = now_ns;
  }
  for (std::size_t i = 0; i < kConditionCount; ++i) {
    const auto condition = static_cast<Condition>(i);
    state_.began[i] += state_.was_ready && state_.conditions.has(condition) && !before.has(condition);
  }

  state_.stamp_ns = now_ns;
  state_.T_world_base = odometry_.T_world_base();
  state_.velocity = odometry_.velocity();
  state_.path_m = odometry_.path_m();
  state_.rotation_rad = odometry_.rotation_rad();
  state_.bumper = bumper_sides_;
  state_.cliff = cliff_sides_;
  state_.wheel_drop = wheel_sides_;
  state_.battery_level = battery_.level();
  state_.battery_v = battery_.voltage_v();
  state_.battery_charge = battery_.charge();
  state_.energy_left_s = battery_.left_s();
  state_.power = battery_.source();
  state_.device = reader_.info();
  state_.rejects = reader_.rejects();
  state_.restarts = reader_.restarts();
}

Twist BaseDriver::next_twist() {
  const Allowance& allowance = state_.verdict.allowance;
  const Twist permitted = permit(wanted_, allowance);
  if (is_still(permitted)) return limits_.stop();
  const Twist limited = limits_.limit(permitted, static_cast<double>(options_.period_ns) * 1e-9);
  // On its way from what it did to what it may do, the limiter passes through what it may not.
  const Twist last_word = permit(limited, allowance);
  if (!(last_word == limited)) limits_.assume(last_word);
  return last_word;
}

void BaseDriver::add_requests(Command& command, TimeNs now_ns) {
  const Signal signal = signals_.update(state_.verdict, state_.conditions, now_ns);
  outputs_.set_led(Led::first, signal.state);
  outputs_.set_led(Led::second, signal.battery);
  if (signal.sound && options_.sounds) command.sound_sequence = signal.sound;
  if (outputs_.word() != sent_outputs_ || now_ns - outputs_sent_ns_ >= kRepeatOutputs_ns) {
    command.outputs = outputs_.word();
    sent_outputs_ = outputs_.word();
    outputs_sent_ns_ = now_ns;
  }
  // Only a base that is there can answer: what is asked before is lost.
  const DeviceInfo& info = reader_.info();
  const bool answered = info.has_hardware && info.has_firmware && info.has_udid;
  if (answered || state_.conditions.has(Condition::silent_base)) return;
  if (has_asked_ && now_ns - asked_ns_ < kAskAgain_ns) return;
  command.request_extra = kAskAll;
  asked_ns_ = now_ns;
  has_asked_ = true;
}

std::size_t BaseDriver::tick(TimeNs now_ns, std::span<std::uint8_t> out) {
  if (has_ticked_ && now_ns < next_tick_ns_) {
    judge_now(now_ns);
    if (permit(state_.commanded, state_.verdict.allowance) == state_.commanded) return 0;
    ++state_.urgent_stops;
    state_.commanded = limits_.stop();
    return encode_base_control(state_.commanded, out);
  }
  note_tick(latches_, now_ns, options_.times);
  judge_now(now_ns);
  // On a fixed grid, so that delays do not add up; a new one after a delay of more than a period.
  next_tick_ns_ += options_.period_ns;
  if (!has_ticked_ || next_tick_ns_ <= now_ns) next_tick_ns_ = now_ns + options_.period_ns;
  has_ticked_ = true;
  ++state_.ticks;

  state_.commanded = next_twist();
  Command command;
  command.base = to_base_control(state_.commanded);
  add_requests(command, now_ns);
  return encode_command(command, out);
}

std::size_t BaseDriver::farewell(std::span<std::uint8_t> out) {
  state_.commanded = limits_.stop();
  wanted_ = {};
  outputs_.set_led(Led::first, LedColour::off);
  outputs_.set_led(Led::second, LedColour::off);
  Command command;
  command.base = BaseControl{};
  command.outputs = outputs_.word();
  return encode_command(command, out);
}

}  // namespace g3d::hal::kobuki
