// SPDX-License-Identifier: Apache-2.0
// The few words of CANopen (CiA 301) that a robot and an emergency-stop node say to each other: heartbeat, emergency
// message, network management command, and one process data object of ours. Pure: frame in, message out.
//
//   0x000           NMT command     [command][node or 0 for all]
//   0x080 + node    emergency       [code lo][code hi][error register][5 bytes of the maker]
//   0x180 + node    status (TPDO 1) see RobotStatus
//   0x700 + node    heartbeat       [state]
#pragma once

#include <array>
#include <cstdint>
#include <variant>

#include "hal/can/can_frame.hpp"

namespace g3d::hal::can {

inline constexpr std::uint8_t kMaxNode = 127;

enum class NmtState : std::uint8_t { boot_up = 0x00, stopped = 0x04, operational = 0x05, pre_operational = 0x7F };
enum class NmtCommand : std::uint8_t {
  start = 0x01,
  stop = 0x02,
  enter_pre_operational = 0x80,
  reset_node = 0x81,
  reset_communication = 0x82,
};

struct Heartbeat {
  std::uint8_t node = 0;  ///< 1 to 127
  NmtState state = NmtState::boot_up;
  bool operator==(const Heartbeat&) const = default;
};

struct Emergency {
  std::uint8_t node = 0;            ///< 1 to 127
  std::uint16_t code = 0;           ///< 0x00xx: an error is over, see error_register for what is left
  std::uint8_t error_register = 0;  ///< object 1001h: which kinds of error stand; 0: none
  std::array<std::uint8_t, 5> maker{};
  /// Everything is well again.
  [[nodiscard]] bool is_all_clear() const { return code <= 0x00FF && error_register == 0; }
  bool operator==(const Emergency&) const = default;
};

struct NmtOrder {
  NmtCommand command = NmtCommand::start;
  std::uint8_t node = 0;  ///< 0: all
  bool operator==(const NmtOrder&) const = default;
};

/// Of the robot, for whoever listens: TPDO 1, 8 bytes, little-endian.
struct RobotStatus {
  std::uint8_t node = 0;          ///< 1 to 127
  std::uint8_t state = 0;         ///< hal::SafetyState
  std::uint16_t conditions = 0;   ///< hal::Conditions, lowest 16 bits
  std::int16_t forward_mmps = 0;  ///< commanded, mm/s
  std::int16_t turn_mradps = 0;   ///< commanded, mrad/s
  std::uint8_t battery_dv = 0;    ///< tenths of a volt
  bool operator==(const RobotStatus&) const = default;
};

enum class NoMessage : std::uint8_t {
  other,          ///< nothing that we know: SDO, SYNC, somebody's process data
  not_canopen,    ///< extended identifier, remote or error frame
  bad_size,       ///< of another length than its kind has
  unknown_value,  ///< a state or command that CiA 301 does not have
  count_,
};
[[nodiscard]] const char* to_string(NoMessage reason);

using Message = std::variant<NoMessage, Heartbeat, Emergency, NmtOrder>;
/// The whole frame is checked before it is taken for a message.
[[nodiscard]] Message decode(const CanFrame& frame);

[[nodiscard]] CanFrame encode(const Heartbeat& heartbeat);
[[nodiscard]] CanFrame encode(const Emergency& emergency);
[[nodiscard]] CanFrame encode(const NmtOrder& order);
[[nodiscard]] CanFrame encode(const RobotStatus& status);
/// False: no status of any node.
[[nodiscard]] bool decode_status(const CanFrame& frame, RobotStatus& status);

}  // namespace g3d::hal::can
