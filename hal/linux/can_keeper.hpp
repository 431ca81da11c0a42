// SPDX-License-Identifier: Apache-2.0
// Keeps a CAN interface going: opens its socket, opens it again after it was unplugged, brings the link up, restarts a
// controller that has given up. Each with a back-off that doubles, so that a broken bus is not shouted at. For a thread
// that may wait.
#pragma once

#include <functional>

#include "hal/linux/can_socket.hpp"
#include "hal/messages.hpp"

namespace g3d::hal {

/// What it does to the system; a test has its own.
struct CanKeeperCalls {
  std::function<Result<int>()> open_socket;
  std::function<Result<void>()> bring_up;  ///< may be empty: somebody else does
  std::function<Result<void>()> restart;   ///< the same
};
/// The real ones. `bitrate` in bit/s, 0: the link is somebody else's business, apart from restarts.
[[nodiscard]] CanKeeperCalls can_keeper_calls(const std::string& interface, std::uint32_t bitrate);

struct CanKeeperTimes {
  TimeNs first_wait_ns = 100'000'000;
  TimeNs longest_wait_ns = 5'000'000'000;
  TimeNs calm_ns = 10'000'000'000;  ///< well for so long, before the first wait counts again
};

struct CanKeeperCounts {
  std::uint64_t openings = 0, failed_openings = 0;
  std::uint64_t ups = 0, failed_ups = 0;
  std::uint64_t restarts = 0, failed_restarts = 0;
};

class CanKeeper {
 public:
  /// `socket` outlives this.
  CanKeeper(CanSocket& socket, CanKeeperCalls calls, const CanKeeperTimes& times = {});
  /// One thread, every tenth of a second or so. Nothing to do: nothing is done.
  void tend(TimeNs now_ns);
  // The same thread
  [[nodiscard]] const CanKeeperCounts& counts() const { return counts_; }
  /// Of the last thing that failed, empty: nothing has.
  [[nodiscard]] const std::string& last_error() const { return last_error_; }

 private:
  enum class Need { nothing, socket, link, restart };
  [[nodiscard]] Need need() const;
  [[nodiscard]] bool note(const Result<void>& outcome, std::uint64_t& done, std::uint64_t& failed);

  CanSocket& socket_;
  const CanKeeperCalls calls_;
  const CanKeeperTimes times_;
  CanKeeperCounts counts_;
  std::string last_error_;
  bool waits_ = false;
  TimeNs wait_ns_ = 0;
  TimeNs next_try_ns_ = 0;
  TimeNs last_need_ns_ = 0;
};

}  // namespace g3d::hal
