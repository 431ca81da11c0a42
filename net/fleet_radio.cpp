// SPDX-License-Identifier: Apache-2.0
#include "net/fleet_radio.hpp"

namespace g3d::net {

bool FleetRadio::send(Address to, mapper::ByteSpan message) {
  const DatagramGate::Sealed sealed = gate_.seal(message, now_ns_);
  if (sealed.verdict != SealVerdict::sealed) {
    ++counts_.not_sealed;
    return false;
  }
  if (!port_.send(to, sealed.datagram)) {
    ++counts_.not_sent;
    return false;
  }
  ++counts_.sent;
  counts_.sent_bytes += sealed.datagram.size();
  return true;
}

FleetRadio::Took FleetRadio::take_one(Sender& sender) {
  const auto received = port_.receive();
  if (!received) return {.is_empty = true};
  ++counts_.received;
  counts_.received_bytes += received->datagram.size();
  const GateTaken taken = gate_.take(received->datagram, received->from, now_ns_);
  Took took;
  if (taken.verdict == GateVerdict::deliver) {
    ++counts_.delivered;
    sender = {taken.robot, taken.session, received->from};
    std::copy(taken.plaintext.begin(), taken.plaintext.end(), message_.begin());
    took = {.is_delivered = true, .bytes = taken.plaintext.size()};
  }
  if (taken.answer.empty()) return took;
  if (port_.send(received->from, taken.answer)) {
    ++counts_.answered;
    counts_.answered_bytes += taken.answer.size();
  } else {
    ++counts_.not_answered;
  }
  return took;
}

}  // namespace g3d::net
