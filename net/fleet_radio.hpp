// SPDX-License-Identifier: Apache-2.0
// Gate and port joined: what gossip sends is sealed, what comes is opened, and nothing is parsed before.
//
//   gossip ──▶ seal ──▶ port          port ──▶ gate ──▶ visit(sender, message) ──▶ gossip
//                         ▲──── answers of the gate ◀──┘
//
// How much is read at a time is bounded, so that a flood costs a bounded share of the time. One thread; nothing
// allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "net/datagram_gate.hpp"
#include "net/datagram_port.hpp"
#include "net/gossip.hpp"

namespace g3d::net {

/// What went through the radio; why the gate refused what it did is in its own counts.
struct RadioCounts {
  std::uint64_t sent = 0;  ///< messages that left; one to everybody counts once
  std::uint64_t sent_bytes = 0;
  std::uint64_t not_sent = 0;    ///< the port took them not
  std::uint64_t not_sealed = 0;  ///< too long, or the counter is used up
  std::uint64_t received = 0;    ///< datagrams, of whomever
  std::uint64_t received_bytes = 0;
  std::uint64_t delivered = 0;  ///< of these messages of the fleet
  std::uint64_t answered = 0;   ///< challenges and responses that left
  std::uint64_t answered_bytes = 0;
  std::uint64_t not_answered = 0;  ///< those that the port took not
};

class FleetRadio final : public Link {
 public:
  /// How many datagrams one receive() reads at most: at 200 calls a second 51,000 a second.
  static constexpr std::size_t kMostAtOnce = 256;

  /// Both outlive this.
  FleetRadio(DatagramGate& gate, DatagramPort& port) : gate_(gate), port_(port) {}

  /// Sealed at the time that was last given to receive(). False: it did not leave.
  bool send(Address to, mapper::ByteSpan message) override;
  [[nodiscard]] bool has_room(Address to) const override { return port_.has_room(to); }

  /// All that has come, up to kMostAtOnce: visit(const Sender&, mapper::ByteSpan message) for every message of the
  /// fleet; the span is valid until visit returns, which may send. A sender's session is that of its gate: another one
  /// at each start of its program, even one that goes on with its layer. Returns how many datagrams came.
  template <class Visit>
  std::size_t receive(hal::TimeNs now_ns, Visit&& visit) {
    now_ns_ = now_ns;
    std::size_t count = 0;
    while (count < kMostAtOnce) {
      Sender sender;
      const Took took = take_one(sender);
      if (took.is_empty) break;
      ++count;
      if (took.is_delivered) visit(static_cast<const Sender&>(sender), mapper::ByteSpan(message_).first(took.bytes));
    }
    return count;
  }

  [[nodiscard]] const RadioCounts& counts() const { return counts_; }

 private:
  struct Took {
    bool is_empty = false;
    bool is_delivered = false;
    std::size_t bytes = 0;
  };
  [[nodiscard]] Took take_one(Sender& sender);

  DatagramGate& gate_;
  DatagramPort& port_;
  hal::TimeNs now_ns_ = 0;
  std::array<std::uint8_t, kMostPlaintext_bytes> message_;  ///< apart from the gate's memory: a visit may send
  RadioCounts counts_;
};

}  // namespace g3d::net
