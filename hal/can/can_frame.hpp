// SPDX-License-Identifier: Apache-2.0
// One CAN 2.0 frame as a plain value, without the kernel's flag bits; and the port through which frames come and go.
#pragma once

#include <array>
#include <cstdint>

namespace g3d::hal::can {

inline constexpr std::uint32_t kMaxStandardId = 0x7FF;
inline constexpr std::uint32_t kMaxExtendedId = 0x1FFFFFFF;
inline constexpr std::size_t kMaxData_bytes = 8;

struct CanFrame {
  std::uint32_t id = 0;      ///< 11 bits, or 29 if extended; of an error frame: its classes (linux/can/error.h)
  bool is_extended = false;  ///< 29-bit identifier
  bool is_remote = false;    ///< asks for data: has a size, but carries none
  bool is_error = false;     ///< made by the kernel, was never on the wire
  std::uint8_t size = 0;     ///< 0 to 8
  std::array<std::uint8_t, kMaxData_bytes> data{};  ///< beyond `size`, and of remote frames: 0
  bool operator==(const CanFrame&) const = default;
};

/// What a port of ours drops or does not send, with the reason.
struct CanCounts {
  std::uint64_t received = 0;
  std::uint64_t sent = 0;
  std::uint64_t error_frames = 0;     ///< told by the kernel
  std::uint64_t malformed = 0;        ///< dropped: of another size than a frame, a lying length or identifier
  std::uint64_t overflowed = 0;       ///< lost in the kernel, because we came too late
  std::uint64_t failed_reads = 0;     ///< other errors of the socket
  std::uint64_t send_queue_full = 0;  ///< not sent: nobody acknowledges, or the bus is too busy
  std::uint64_t not_sent_down = 0;    ///< not sent: the link is down, or the bus is off
  std::uint64_t not_sent = 0;         ///< not sent for another reason
  std::uint64_t bus_offs = 0;         ///< the controller gave up after too many errors
  std::uint64_t bus_restarts = 0;     ///< and came back
  std::uint64_t link_losses = 0;      ///< taken down, or unplugged
  std::uint64_t reopened = 0;         ///< the interface came back as a new one
};

class CanPort {
 public:
  virtual ~CanPort() = default;
  /// The next frame that is there, error frames included; false: none. Never waits. One thread.
  [[nodiscard]] virtual bool read(CanFrame& frame) = 0;
  /// False: not sent, and counted. Never waits. The same thread.
  virtual bool write(const CanFrame& frame) = 0;
  [[nodiscard]] virtual const CanCounts& counts() const = 0;
};

}  // namespace g3d::hal::can
