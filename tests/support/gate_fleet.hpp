// SPDX-License-Identifier: Apache-2.0
// Robots with a gate each, and the air between them: what one seals the other takes, and answers go back until there
// are none. Everything that is sent is kept, as by somebody who listens.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "net/datagram_gate.hpp"

namespace g3d::test {

using DatagramBytes = std::vector<std::uint8_t>;

inline net::FleetKey copy_of(const net::FleetKey& keys) {
  net::FleetKey copy;
  copy.epoch = keys.epoch;
  copy.key = keys.key.copy();
  if (keys.previous) copy.previous = keys.previous->copy();
  copy.revoked = keys.revoked;
  return copy;
}

struct GateRobot {
  GateRobot(const net::FleetKey& keys, std::uint64_t robot, std::size_t most_sessions = 16)
      : source(1000 + robot),
        gate(copy_of(keys), {.robot = robot, .incarnation = robot + 40, .most_sessions = most_sessions}) {}
  std::uint64_t source;
  net::DatagramGate gate;
};

inline DatagramBytes seal_text(GateRobot& from, std::string_view text, hal::TimeNs now_ns) {
  const auto sealed = from.gate.seal({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, now_ns);
  return {sealed.datagram.begin(), sealed.datagram.end()};
}

struct Air {
  std::vector<DatagramBytes> heard;

  /// What `to` delivers of it; answers go to and fro.
  std::optional<std::string> carry(GateRobot& from, GateRobot& to, DatagramBytes datagram, hal::TimeNs now_ns) {
    GateRobot* sender = &from;
    GateRobot* receiver = &to;
    std::optional<std::string> delivered;
    for (;;) {
      heard.push_back(datagram);
      const net::GateTaken taken = receiver->gate.take(datagram, sender->source, now_ns);
      if (taken.verdict == net::GateVerdict::deliver) delivered.emplace(taken.plaintext.begin(), taken.plaintext.end());
      if (taken.answer.empty()) return delivered;
      datagram.assign(taken.answer.begin(), taken.answer.end());
      std::swap(sender, receiver);
    }
  }
  /// One datagram with `text`.
  std::optional<std::string> say(GateRobot& from, GateRobot& to, std::string_view text, hal::TimeNs now_ns) {
    return carry(from, to, seal_text(from, text, now_ns), now_ns);
  }
};

}  // namespace g3d::test
