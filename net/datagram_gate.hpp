// SPDX-License-Identifier: Apache-2.0
// What stands between the network and everything else: only datagrams of the fleet, fresh ones, each once, come
// through, with the robot that sent them. Both ways are apart: that we believe a robot does not mean that it believes
// us. One thread; nothing allocates after construction.
//
// A datagram goes through: its size and kind; rate limits; authentication; then, if its session is known, the replay
// window, else a challenge goes back to where it came from. Nothing is parsed before it is authenticated. Known
// sessions are challenged again from time to time, along with a delivery.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/messages.hpp"
#include "net/datagram_seal.hpp"
#include "net/fleet_key.hpp"
#include "net/gate_refusals.hpp"
#include "net/rate_limit.hpp"
#include "net/session_table.hpp"
#include "net/straggler_watch.hpp"

namespace g3d::net {

/// 4000 datagrams of 1200 bytes are 5 MB/s, more than a shared radio carries. A forger is read 20 times a second.
inline constexpr RateLimits kDatagramLimits{
    .per_source = {4000.0, 1000.0}, .overall = {2000.0, 500.0}, .forged_cost = 200.0};
/// A fleet that restarts asks everybody once or twice.
inline constexpr RateLimits kAnswerLimits{.per_source = {8.0, 8.0}, .overall = {64.0, 64.0}};

struct GateSettings {
  std::uint64_t robot = 0;
  std::uint64_t incarnation = 0;
  std::size_t most_sessions = 64;
  std::size_t most_sources = 512;
  RateLimits datagrams = kDatagramLimits;
  RateLimits challenges = kChallengeLimits;
  RateLimits answers = kAnswerLimits;
};

enum class GateVerdict : std::uint8_t {
  deliver,  ///< `plaintext`, from `robot`; send `answer` as well, unless it is empty
  answer,   ///< send `answer` to where the datagram came from
  handled,  ///< nothing is left to do
  refused,  ///< because of `reason`
};

/// Spans are valid until the next call of the gate.
struct GateTaken {
  GateVerdict verdict = GateVerdict::handled;
  GateRefusal reason = GateRefusal::count_;
  std::uint64_t robot = 0;
  std::uint64_t incarnation = 0;
  std::uint64_t session = 0;  ///< of a delivery: another one at each start of its sender
  std::span<const std::uint8_t> plaintext{};
  std::span<const std::uint8_t> answer{};
};

class DatagramGate {
 public:
  DatagramGate(FleetKey keys, const GateSettings& settings, SenderStart start = fresh_sender_start());

  /// `source` is any number that stands for where it came from; see source_of().
  [[nodiscard]] GateTaken take(std::span<const std::uint8_t> datagram, std::uint64_t source, hal::TimeNs now_ns);

  struct Sealed {
    SealVerdict verdict;
    std::span<const std::uint8_t> datagram;  ///< empty unless sealed; valid until the next call of the gate
  };
  [[nodiscard]] Sealed seal(std::span<const std::uint8_t> plaintext, hal::TimeNs now_ns);

  /// The file was changed: other keys, other revoked robots. Sessions stay known.
  void use_keys(FleetKey keys);

  [[nodiscard]] const FleetKey& keys() const { return keys_; }
  [[nodiscard]] std::span<const KnownSession> sessions() const { return sessions_.known(); }
  [[nodiscard]] std::uint64_t own_session() const { return sealer_.session(); }
  /// Whether a robot without the current key was heard of late: the rotation is not through.
  [[nodiscard]] bool hears_stragglers(hal::TimeNs now_ns) const {
    return keys_.previous && stragglers_.hears_one(now_ns);
  }
  [[nodiscard]] GateCounts counts() const;

 private:
  [[nodiscard]] GateTaken refuse(GateRefusal reason);
  [[nodiscard]] GateTaken take_data(const Opener::Opened& opened, std::uint64_t source, hal::TimeNs now_ns);
  [[nodiscard]] GateTaken take_handshake(const Opener::Opened& opened, std::uint64_t source, hal::TimeNs now_ns);
  [[nodiscard]] GateTaken take_challenge(const Challenge& challenge, const Envelope& envelope, std::uint64_t source,
                                         hal::TimeNs now_ns);
  [[nodiscard]] GateTaken take_response(const Response& response, const Envelope& envelope, std::uint64_t source,
                                        hal::TimeNs now_ns);
  /// Under the epoch of what it answers, which its receiver can open.
  [[nodiscard]] GateTaken answer(std::span<const std::uint8_t> message, const Envelope& to);
  [[nodiscard]] Sealed seal_as(bool handshake, bool previous_epoch, std::span<const std::uint8_t> plaintext);
  /// What the rate of this datagram is counted by; see the source file.
  [[nodiscard]] std::uint64_t payer(const Envelope& envelope, std::uint64_t source, hal::TimeNs now_ns,
                                    RateClass& rate_class);

  FleetKey keys_;
  Sealer sealer_;
  const Opener opener_;
  SessionTable sessions_;
  RateLimit datagram_limit_;
  RateLimit answer_limit_;
  GateCounts counts_;
  StragglerWatch stragglers_;
  std::array<std::uint8_t, kMostDatagram_bytes> opened_;
  std::array<std::uint8_t, kMostDatagram_bytes> sealed_;
};

}  // namespace g3d::net
