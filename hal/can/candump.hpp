// SPDX-License-Identifier: Apache-2.0
// One line of a candump log: `(1700000000.123456) can0 181#0011223344556677`. Eight hexadecimal digits of identifier
// are an extended or an error frame, three a standard one; `#R` asks for data, with the size behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "hal/can/can_frame.hpp"
#include "hal/messages.hpp"

namespace g3d::hal::can {

struct StampedCanFrame {
  TimeNs t_ns = 0;  ///< in steps of a microsecond once it was written
  CanFrame frame;
  bool operator==(const StampedCanFrame&) const = default;
};

/// IFNAMSIZ of Linux, without the zero.
inline constexpr std::size_t kMaxInterfaceName = 15;
inline constexpr std::size_t kMaxCandumpLine = 80;
/// Stamps of lines are 0 or later: a robot's clock begins at its start.
inline constexpr TimeNs kMaxCandumpStamp_s = 4'000'000'000;

/// The line with its newline into `out`, which has room for kMaxCandumpLine; returns its length. Allocates nothing.
/// What does not fit a line's limits (a stamp, a name) is cut to them.
std::size_t format_candump_to(char* out, const StampedCanFrame& stamped, std::string_view interface);

enum class BadCandump : std::uint8_t {
  none,
  stamp,       ///< not `(SECONDS.MICROSECONDS)`
  interface,   ///< no name of 1 to 15 characters
  identifier,  ///< not 3 or 8 hexadecimal digits, or too large
  data,        ///< not up to 8 bytes of two hexadecimal digits each
  flexible,    ///< `##`: CAN FD, which is not handled here
  rest,        ///< something behind the frame
};
[[nodiscard]] const char* to_string(BadCandump reason);

struct CandumpLine {
  BadCandump bad = BadCandump::none;
  StampedCanFrame stamped;     ///< valid if nothing is bad
  std::string_view interface;  ///< in the text that was parsed
};
/// `line` without its newline. The whole line is checked.
[[nodiscard]] CandumpLine parse_candump(std::string_view line);

}  // namespace g3d::hal::can
