// SPDX-License-Identifier: Apache-2.0
// A small process that holds the base's line too. The base keeps its last command, so if the process that drives it
// dies or hangs, somebody else has to say stop: the guard sends zero speed from the moment in which the heartbeat is
// missed, until it is back. It knows nothing but the line, the heartbeat and ten bytes.
//
//   main process --- heartbeat: a counter in a shared page ---> guard process
//                --- socket: a new line, or the good end   --->      |
//        |                                                           |
//        +------------------ the serial line ------------------------+
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal::kobuki {

/// Base control, speed 0, radius 0 (Kobuki protocol, command 1).
inline constexpr std::array<std::uint8_t, 10> kZeroSpeedPacket = {0xaa, 0x55, 0x06, 0x01, 0x04, 0, 0, 0, 0, 0x03};

class LineGuard {
 public:
  struct Times {
    TimeNs missed_ns = 200'000'000;  ///< without a heartbeat until it takes over
    TimeNs period_ns = 20'000'000;   ///< between its packets
    int farewell_packets = 50;       ///< after the main process died
    int hand_over_packets = 5;       ///< at a good end
  };

  /// Forks. Best before threads and big memory; safe afterwards too, as the child only makes system calls.
  /// `line_fd` may be -1 and come later by hand_over. Errors: io_error.
  [[nodiscard]] static Result<LineGuard> start(int line_fd, Times times);
  [[nodiscard]] static Result<LineGuard> start(int line_fd) { return start(line_fd, Times{}); }

  LineGuard(LineGuard&& other) noexcept;
  LineGuard& operator=(LineGuard&&) = delete;
  /// The good end: the guard sends its zeros and goes. Send your own before, and close the line after.
  ~LineGuard();

  /// Any thread, without a system call. At least every `missed_ns` / 2; the thread that drives the line, so that the
  /// guard also sees when that one hangs.
  void beat();
  /// The line was opened anew. The caller keeps its descriptor. Any one thread.
  [[nodiscard]] bool hand_over(int line_fd);
  /// Whether the process still runs. One thread.
  [[nodiscard]] bool alive();
  /// Any thread. Zero packets that the guard has sent so far.
  [[nodiscard]] std::uint64_t zeros_sent() const;
  [[nodiscard]] pid_t process() const { return process_; }

 private:
  struct Shared;
  LineGuard(pid_t process, int socket, Shared* shared) : process_(process), socket_(socket), shared_(shared) {}

  pid_t process_ = -1;
  int socket_ = -1;
  Shared* shared_ = nullptr;
  [[noreturn]] static void watch(int line_fd, int socket, pid_t parent, Shared& shared, const Times& times);
};

}  // namespace g3d::hal::kobuki
