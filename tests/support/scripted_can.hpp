// SPDX-License-Identifier: Apache-2.0
// A CAN bus in memory: frames that a test puts there, and those that were written; and a socket pair that carries
// struct can_frame as a raw CAN socket does, where the kernel has no CAN.
#pragma once

#include <linux/can.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <deque>
#include <optional>
#include <vector>

#include "hal/can/canopen.hpp"

namespace g3d::test {

class ScriptedCan final : public hal::can::CanPort {
 public:
  bool read(hal::can::CanFrame& frame) override {
    if (waiting.empty()) return false;
    frame = waiting.front();
    waiting.pop_front();
    return true;
  }
  bool write(const hal::can::CanFrame& frame) override {
    if (is_down) return false;
    written.push_back(frame);
    return true;
  }
  const hal::can::CanCounts& counts() const override { return counts_; }
  /// The last that was written with this identifier.
  std::optional<hal::can::CanFrame> last(std::uint32_t id) const {
    for (std::size_t i = written.size(); i-- > 0;) {
      if (written[i].id == id) return written[i];
    }
    return std::nullopt;
  }

  std::deque<hal::can::CanFrame> waiting;
  std::vector<hal::can::CanFrame> written;
  bool is_down = false;

 private:
  hal::can::CanCounts counts_;
};

/// Two ends that carry whole frames; ours is given away.
struct CanPair {
  CanPair() {
    std::array<int, 2> ends{};
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) == 0);
    ours = ends[0];
    bus = ends[1];
  }
  ~CanPair() { unplug(); }
  CanPair(const CanPair&) = delete;
  CanPair& operator=(const CanPair&) = delete;
  void say(std::uint32_t id, const std::vector<std::uint8_t>& data) const {
    can_frame raw{};
    raw.can_id = id;
    raw.can_dlc = static_cast<std::uint8_t>(data.size());
    if (!data.empty()) std::memcpy(raw.data, data.data(), data.size());
    REQUIRE(::write(bus, &raw, sizeof raw) == sizeof raw);
  }
  std::optional<can_frame> hear() const {
    can_frame raw{};
    if (::read(bus, &raw, sizeof raw) != sizeof raw) return std::nullopt;
    return raw;
  }
  void unplug() {
    if (bus >= 0) ::close(bus);
    bus = -1;
  }
  int ours = -1;  ///< whoever takes it closes it
  int bus = -1;
};

}  // namespace g3d::test
