// SPDX-License-Identifier: Apache-2.0
#include "hal/can/can_safety.hpp"

#include <algorithm>
#include <cmath>

#include "hal/can/candump.hpp"
#include "hal/replay/text_recorder.hpp"

namespace g3d::hal::can {
namespace {

// More than a bus of 1 Mbit/s carries in two milliseconds: 47 bits at least each, 43 frames.
constexpr int kMostFramesPerLook = 64;
constexpr TimeNs kStartAgain_ns = 1'000'000'000;

std::int16_t thousandths(double value) {
  return static_cast<std::int16_t>(std::clamp(std::round(value * 1000.0), -32768.0, 32767.0));
}

}  // namespace

CanSafety::CanSafety(CanPort& port, const CanSafetyOptions& options, TextRecorder* recorder)
    : port_(port), options_(options), recorder_(recorder), estop_(options.estop) {}

StopWord CanSafety::look(TimeNs now_ns) {
  CanFrame frame;
  int read = 0;
  for (; read < kMostFramesPerLook && port_.read(frame); ++read) {
    ++counts_.frames;
    record(frame, now_ns);
    take(decode(frame), now_ns);
  }
  counts_.left_waiting += read == kMostFramesPerLook;

  StopWord word = options_.has_estop ? estop_.word(now_ns) : StopWord::go;
  if (was_told_to_stop_ || (state_ != NmtState::operational && has_begun_)) word = StopWord::stop;
  was_told_to_stop_ = false;
  if (options_.has_estop && options_.starts_estop && estop_.is_alive(now_ns) && now_ns >= next_start_ns_ &&
      estop_.state() == NmtState::pre_operational) {
    next_start_ns_ = now_ns + kStartAgain_ns;
    ++counts_.starts_sent;
    send(encode(NmtOrder{NmtCommand::start, options_.estop.node}), now_ns);
  }
  return word;
}

void CanSafety::take(const Message& message, TimeNs now_ns) {
  if (const auto* reason = std::get_if<NoMessage>(&message)) ++counts_.ignored[static_cast<std::size_t>(*reason)];
  if (const auto* order = std::get_if<NmtOrder>(&message)) obey(*order);
  estop_.on_message(message, now_ns);
}

// There is nothing in us to reset that would let us drive again: a reset by the master is a stop as well, and only its
// start ends it.
void CanSafety::obey(const NmtOrder& order) {
  if (order.node != 0 && order.node != options_.own_node) return;
  ++counts_.orders;
  switch (order.command) {
    case NmtCommand::start:
      state_ = NmtState::operational;
      return;
    case NmtCommand::stop:
      state_ = NmtState::stopped;
      break;
    case NmtCommand::enter_pre_operational:
    case NmtCommand::reset_node:
    case NmtCommand::reset_communication:
      state_ = NmtState::pre_operational;
      break;
  }
  has_begun_ = true;
  was_told_to_stop_ = true;
}

void CanSafety::show(const SafetyNews& news, TimeNs now_ns) {
  if (now_ns >= next_heartbeat_ns_) {
    next_heartbeat_ns_ = now_ns + options_.heartbeat_ns;
    send(encode(Heartbeat{options_.own_node, state_}), now_ns);
    // As a node that needs no master: from boot-up it goes on by itself.
    if (!has_begun_) state_ = NmtState::operational;
    has_begun_ = true;
  }
  if (now_ns < next_status_ns_ || state_ != NmtState::operational) return;
  next_status_ns_ = now_ns + options_.status_ns;
  RobotStatus status;
  status.node = options_.own_node;
  status.state = static_cast<std::uint8_t>(news.state);
  status.conditions = static_cast<std::uint16_t>(news.conditions.bits);
  status.forward_mmps = thousandths(news.commanded.forward_mps);
  status.turn_mradps = thousandths(news.commanded.turn_radps);
  status.battery_dv = static_cast<std::uint8_t>(std::clamp(std::round(news.battery_v * 10.0), 0.0, 255.0));
  send(encode(status), now_ns);
}

void CanSafety::say_farewell(TimeNs now_ns) {
  state_ = NmtState::stopped;
  send(encode(Heartbeat{options_.own_node, state_}), now_ns);
}

void CanSafety::send(const CanFrame& frame, TimeNs now_ns) {
  if (port_.write(frame)) record(frame, now_ns);
}

void CanSafety::record(const CanFrame& frame, TimeNs t_ns) {
  if (recorder_ == nullptr) return;
  std::array<char, kMaxCandumpLine> line;
  recorder_->put({line.data(), format_candump_to(line.data(), {t_ns, frame}, options_.interface)});
}

}  // namespace g3d::hal::can
