// SPDX-License-Identifier: Apache-2.0
#include "hal/can/canopen.hpp"

#include <algorithm>

namespace g3d::hal::can {
namespace {

constexpr std::uint32_t kNmt = 0x000, kEmergency = 0x080, kStatus = 0x180, kHeartbeat = 0x700;
constexpr std::uint8_t kEmergency_bytes = 8, kStatus_bytes = 8, kNmt_bytes = 2, kHeartbeat_bytes = 1;

bool is_plain(const CanFrame& f) { return !f.is_extended && !f.is_remote && !f.is_error; }
/// The node, if `id` is that of `function` with one.
std::uint8_t node_of(std::uint32_t id, std::uint32_t function) {
  return id > function && id <= function + kMaxNode ? static_cast<std::uint8_t>(id - function) : std::uint8_t{0};
}
std::uint16_t get_u16(const CanFrame& f, std::size_t at) {
  return static_cast<std::uint16_t>(f.data[at] | f.data[at + 1] << 8);
}
void put_u16(CanFrame& f, std::size_t at, std::uint16_t value) {
  f.data[at] = static_cast<std::uint8_t>(value);
  f.data[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

Message heartbeat_of(const CanFrame& f, std::uint8_t node) {
  if (f.size != kHeartbeat_bytes) return NoMessage::bad_size;
  // Bit 7 is the toggle bit of the older node guarding, 0 in a heartbeat.
  const auto state = static_cast<NmtState>(f.data[0]);
  switch (state) {
    case NmtState::boot_up:
    case NmtState::stopped:
    case NmtState::operational:
    case NmtState::pre_operational:
      return Heartbeat{node, state};
  }
  return NoMessage::unknown_value;
}

Message order_of(const CanFrame& f) {
  if (f.size != kNmt_bytes) return NoMessage::bad_size;
  if (f.data[1] > kMaxNode) return NoMessage::unknown_value;
  const auto command = static_cast<NmtCommand>(f.data[0]);
  switch (command) {
    case NmtCommand::start:
    case NmtCommand::stop:
    case NmtCommand::enter_pre_operational:
    case NmtCommand::reset_node:
    case NmtCommand::reset_communication:
      return NmtOrder{command, f.data[1]};
  }
  return NoMessage::unknown_value;
}

Message emergency_of(const CanFrame& f, std::uint8_t node) {
  if (f.size != kEmergency_bytes) return NoMessage::bad_size;
  Emergency emergency{node, get_u16(f, 0), f.data[2], {}};
  std::copy_n(f.data.begin() + 3, emergency.maker.size(), emergency.maker.begin());
  return emergency;
}

CanFrame frame_of(std::uint32_t id, std::uint8_t size) {
  CanFrame f;
  f.id = id;
  f.size = size;
  return f;
}

}  // namespace

const char* to_string(NoMessage reason) {
  switch (reason) {
    case NoMessage::other:
      return "other";
    case NoMessage::not_canopen:
      return "not_canopen";
    case NoMessage::bad_size:
      return "bad_size";
    case NoMessage::unknown_value:
      return "unknown_value";
    case NoMessage::count_:
      break;
  }
  return "unknown";
}

Message decode(const CanFrame& frame) {
  if (!is_plain(frame)) return NoMessage::not_canopen;
  if (frame.id == kNmt) return order_of(frame);
  if (const std::uint8_t node = node_of(frame.id, kHeartbeat)) return heartbeat_of(frame, node);
  if (const std::uint8_t node = node_of(frame.id, kEmergency)) return emergency_of(frame, node);
  return NoMessage::other;
}

CanFrame encode(const Heartbeat& heartbeat) {
  CanFrame f = frame_of(kHeartbeat + heartbeat.node, kHeartbeat_bytes);
  f.data[0] = static_cast<std::uint8_t>(heartbeat.state);
  return f;
}

CanFrame encode(const Emergency& emergency) {
  CanFrame f = frame_of(kEmergency + emergency.node, kEmergency_bytes);
  put_u16(f, 0, emergency.code);
  f.data[2] = emergency.error_register;
  std::copy(emergency.maker.begin(), emergency.maker.end(), f.data.begin() + 3);
  return f;
}

CanFrame encode(const NmtOrder& order) {
  CanFrame f = frame_of(kNmt, kNmt_bytes);
  f.data[0] = static_cast<std::uint8_t>(order.command);
  f.data[1] = order.node;
  return f;
}

CanFrame encode(const RobotStatus& status) {
  CanFrame f = frame_of(kStatus + status.node, kStatus_bytes);
  f.data[0] = status.state;
  put_u16(f, 1, status.conditions);
  put_u16(f, 3, static_cast<std::uint16_t>(status.forward_mmps));
  put_u16(f, 5, static_cast<std::uint16_t>(status.turn_mradps));
  f.data[7] = status.battery_dv;
  return f;
}

bool decode_status(const CanFrame& frame, RobotStatus& status) {
  const std::uint8_t node = node_of(frame.id, kStatus);
  if (!is_plain(frame) || node == 0 || frame.size != kStatus_bytes) return false;
  status = {node,
            frame.data[0],
            get_u16(frame, 1),
            static_cast<std::int16_t>(get_u16(frame, 3)),
            static_cast<std::int16_t>(get_u16(frame, 5)),
            frame.data[7]};
  return true;
}

}  // namespace g3d::hal::can
