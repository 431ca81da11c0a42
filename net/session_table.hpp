// SPDX-License-Identifier: Apache-2.0
// Which sessions speak now. That a datagram is authentic does not say when it was sent: it may be a recording from
// before our restart, or from before its sender's. So the first one of an unknown session proves nothing but that it is
// worth a challenge, and only a response that carries the challenge makes the session known; what it sent before that
// response is refused for ever. Thus nothing has to be kept on disk, on either side. Nor is a session believed for
// ever: somebody who keeps its datagrams from us could hand them over later, one by one. So it has to prove itself
// again and again, and nothing is delivered that is older than kProvenFor_ns and the time to answer a challenge. One
// thread; nothing allocates after construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "hal/messages.hpp"
#include "net/challenge_book.hpp"
#include "net/fleet_key.hpp"
#include "net/gate_refusals.hpp"
#include "net/handshake_message.hpp"
#include "net/replay_window.hpp"

namespace g3d::net {

/// A session that has proved itself, and what it said of itself.
struct KnownSession {
  std::uint64_t session = 0;
  std::uint64_t robot = 0;
  std::uint64_t incarnation = 0;
  std::uint64_t source = 0;  ///< where its last fresh datagram came from
  hal::TimeNs heard_ns = 0;
  hal::TimeNs proven_ns = 0;  ///< when its last response came
  ReplayWindow window;
};

/// Who we are.
struct OwnIdentity {
  std::uint64_t session = 0;
  std::uint64_t robot = 0;
  std::uint64_t incarnation = 0;
};

class SessionTable {
 public:
  static constexpr hal::TimeNs kProvenFor_ns = 30'000 * hal::kMillisecond_ns;
  /// From then on it is asked again while it is still believed, so that nothing is lost.
  static constexpr hal::TimeNs kProveAgainAfter_ns = 10'000 * hal::kMillisecond_ns;

  /// Knows `most_sessions` (at least 1) at a time: dozens, they are searched one by one. Of more, the one that was
  /// silent longest is forgotten, and challenged again if it speaks.
  SessionTable(const OwnIdentity& own, std::size_t most_sessions, const RateLimits& challenges = kChallengeLimits);

  /// nullptr if unknown, or proven too long ago. Valid until the next call but take() and challenge().
  [[nodiscard]] KnownSession* find(std::uint64_t session, hal::TimeNs now_ns);
  /// Of a known session's datagram: nothing if it is fresh, else why not. Authenticated datagrams only.
  [[nodiscard]] std::optional<GateRefusal> take(KnownSession& known, std::uint64_t counter, std::uint64_t source,
                                                hal::TimeNs now_ns);
  [[nodiscard]] static bool should_prove_again(const KnownSession& known, hal::TimeNs now_ns) {
    return now_ns - known.proven_ns >= kProveAgainAfter_ns;
  }
  /// The challenge to send to `source` for a session, or why none: own_session, unproven, challenge_rate.
  [[nodiscard]] std::variant<Challenge, GateRefusal> challenge(std::uint64_t session, std::uint64_t source,
                                                               hal::TimeNs now_ns);
  /// A response that came as datagram `counter` of `session`: makes it known, for some time, or says why not:
  /// stale_response, revoked, same_robot, own_session, replayed, too_old. A robot's session before is forgotten.
  [[nodiscard]] std::optional<GateRefusal> prove(std::uint64_t session, std::uint64_t counter, const Response& response,
                                                 std::uint64_t source, hal::TimeNs now_ns);
  /// The revoked from now on; their sessions are forgotten.
  void use_revoked(std::span<const std::uint64_t> robots);

  [[nodiscard]] std::span<const KnownSession> known() const { return {known_.data(), used_}; }
  [[nodiscard]] const OwnIdentity& own() const { return own_; }
  [[nodiscard]] std::uint64_t evicted() const { return evicted_; }
  [[nodiscard]] std::uint64_t superseded() const { return superseded_; }
  [[nodiscard]] std::uint64_t expired() const { return expired_; }

 private:
  [[nodiscard]] bool is_revoked(std::uint64_t robot) const;
  void forget(KnownSession& known) { known = known_[--used_]; }
  [[nodiscard]] KnownSession& place_for(std::uint64_t robot);

  const OwnIdentity own_;
  std::vector<KnownSession> known_;  ///< the first used_ of them
  std::size_t used_ = 0;
  std::vector<std::uint64_t> revoked_;
  ChallengeBook challenges_;
  std::uint64_t evicted_ = 0;
  std::uint64_t superseded_ = 0;
  std::uint64_t expired_ = 0;
};

}  // namespace g3d::net
