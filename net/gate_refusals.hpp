// SPDX-License-Identifier: Apache-2.0
// Why a datagram was not believed, and what became of the others. Every datagram is counted once; `to_string` names the
// reason in the report.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace g3d::net {

enum class GateRefusal : std::uint8_t {
  too_short,            ///< less than an empty envelope
  too_long,             ///< more than 1200 bytes
  unknown_format,       ///< not of this protocol, or of a later one
  unknown_epoch,        ///< sealed with a key that is not, or no longer, in our file
  own_session,          ///< our own datagram came back
  source_rate,          ///< this source sends too much, or forged too much
  overall_rate,         ///< sources that have proved nothing send too much together
  forged,               ///< not sealed with the fleet's key, or changed on the way
  replayed,             ///< seen before, or from before its session was proved
  too_old,              ///< 1024 or more behind the newest of its session
  malformed_handshake,  ///< authentic, but neither challenge nor response
  foreign_challenge,    ///< asks another session than ours, such as the one before our restart
  answer_rate,          ///< asked more often than we answer
  unproven,             ///< its session was challenged a moment ago, and has not answered yet
  challenge_rate,       ///< its session would have to be challenged, more often than we do
  stale_response,       ///< answers no challenge that is open: late, for the second time, or a recording
  revoked,              ///< from a robot on the list of the revoked
  same_robot,           ///< claims to be the robot that we are: two have the same id
  count_,
};
inline constexpr std::size_t kGateRefusalCount = static_cast<std::size_t>(GateRefusal::count_);
[[nodiscard]] const char* to_string(GateRefusal reason);

/// One writer; other threads get copies.
struct GateCounts {
  std::array<std::uint64_t, kGateRefusalCount> by_reason{};
  std::uint64_t delivered = 0;
  std::uint64_t challenged = 0;    ///< not delivered, because their session has to prove itself first
  std::uint64_t answered = 0;      ///< challenges to us
  std::uint64_t proven = 0;        ///< responses that made a session known
  std::uint64_t proven_again = 0;  ///< those of sessions that were still known: they are asked again and again
  // Of these, what the table of sessions did:
  std::uint64_t evicted = 0;     ///< sessions forgotten because the table was full
  std::uint64_t expired = 0;     ///< sessions forgotten because they did not prove themselves again in time
  std::uint64_t superseded = 0;  ///< sessions forgotten because their robot began another one
  // And what was sent:
  std::uint64_t sealed = 0;
  std::uint64_t sealed_previous = 0;  ///< of these under the previous epoch; rises while robots lack the current one
  std::uint64_t not_sealed = 0;       ///< too long, or the counter is used up

  [[nodiscard]] std::uint64_t operator[](GateRefusal reason) const {
    return by_reason[static_cast<std::size_t>(reason)];
  }
  void count(GateRefusal reason) { ++by_reason[static_cast<std::size_t>(reason)]; }
  [[nodiscard]] std::uint64_t refused() const;
  /// All that came.
  [[nodiscard]] std::uint64_t taken() const {
    return delivered + challenged + answered + proven + proven_again + refused();
  }
};

}  // namespace g3d::net
