// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/can_keeper.hpp"

#include <algorithm>
#include <utility>

#include "hal/linux/can_link.hpp"

namespace g3d::hal {

CanKeeperCalls can_keeper_calls(const std::string& interface, std::uint32_t bitrate) {
  CanKeeperCalls calls;
  calls.open_socket = [interface] { return open_can_socket(interface); };
  calls.restart = [interface] { return restart_can(interface); };
  if (bitrate > 0) {
    // Not one that is up already, by somebody else or by our own restart: setting the bit rate would take it down.
    calls.bring_up = [interface, bitrate]() -> Result<void> {
      return link_is_up(interface) ? Result<void>{} : bring_can_up(interface, bitrate);
    };
  }
  return calls;
}

CanKeeper::CanKeeper(CanSocket& socket, CanKeeperCalls calls, const CanKeeperTimes& times)
    : socket_(socket), calls_(std::move(calls)), times_(times), wait_ns_(times.first_wait_ns) {}

CanKeeper::Need CanKeeper::need() const {
  if (socket_.needs_socket()) return Need::socket;
  if (socket_.bus_is_off() && calls_.restart) return Need::restart;
  if (socket_.link_is_down() && calls_.bring_up) return Need::link;
  return Need::nothing;
}

bool CanKeeper::note(const Result<void>& outcome, std::uint64_t& done, std::uint64_t& failed) {
  ++(outcome ? done : failed);
  if (!outcome) last_error_ = outcome.error().text;
  return outcome.ok();
}

void CanKeeper::tend(TimeNs now_ns) {
  const Need what = need();
  if (what == Need::nothing) {
    waits_ = false;
    if (now_ns - last_need_ns_ >= times_.calm_ns) wait_ns_ = times_.first_wait_ns;
    return;
  }
  last_need_ns_ = now_ns;
  if (!waits_) {  // the first try, too, waits: a bus that is off is left alone for a moment
    waits_ = true;
    next_try_ns_ = now_ns + wait_ns_;
    wait_ns_ = std::min(2 * wait_ns_, times_.longest_wait_ns);
    return;
  }
  if (now_ns < next_try_ns_) return;
  next_try_ns_ = now_ns + wait_ns_;
  wait_ns_ = std::min(2 * wait_ns_, times_.longest_wait_ns);
  switch (what) {
    case Need::socket: {
      // Its link first: a new interface comes without a bit rate.
      if (calls_.bring_up && !note(calls_.bring_up(), counts_.ups, counts_.failed_ups)) return;
      const Result<int> fd = calls_.open_socket();
      if (note(fd ? Result<void>{} : Result<void>(fd.error()), counts_.openings, counts_.failed_openings)) {
        socket_.hand_over(fd.value());
      }
      return;
    }
    case Need::link:
      if (note(calls_.bring_up(), counts_.ups, counts_.failed_ups)) socket_.note_link_up();
      return;
    case Need::restart:
      (void)note(calls_.restart(), counts_.restarts, counts_.failed_restarts);
      return;
    case Need::nothing:
      return;
  }
}

}  // namespace g3d::hal
