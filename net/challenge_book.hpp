// SPDX-License-Identifier: Apache-2.0
// Challenges that wait for their response: which may be made, which are open, each to be answered once and soon. A
// recording can make us ask, so there are few of them, for one source and for all. One thread; nothing allocates after
// construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>

#include "hal/messages.hpp"
#include "net/gate_refusals.hpp"
#include "net/handshake_message.hpp"
#include "net/rate_limit.hpp"

namespace g3d::net {

/// As many robots as a fleet has may ask at once after a restart; later on, challenges are rare.
inline constexpr RateLimits kChallengeLimits{.per_source = {4.0, 4.0}, .overall = {16.0, 32.0}};

class ChallengeBook {
 public:
  static constexpr hal::TimeNs kAnswerWithin_ns = 2000 * hal::kMillisecond_ns;
  /// A challenge that may have been lost is sent again, with the same nonce and no later end.
  static constexpr hal::TimeNs kAskAgainAfter_ns = 250 * hal::kMillisecond_ns;
  /// As many as kChallengeLimits let through in the time to answer.
  static constexpr std::size_t kMostOpen = 64;

  explicit ChallengeBook(const RateLimits& limits = kChallengeLimits);

  /// The challenge to send to `source`, or why none is sent now: unproven or challenge_rate. Each source has a
  /// challenge of its own, so that whoever replays a session from elsewhere cannot keep that session from being asked.
  [[nodiscard]] std::variant<Challenge, GateRefusal> ask(std::uint64_t session, std::uint64_t source,
                                                         hal::TimeNs now_ns);
  /// Whether `session` was asked with `nonce`; it was then asked for the last time.
  [[nodiscard]] bool redeem(std::uint64_t nonce, std::uint64_t session, hal::TimeNs now_ns);

 private:
  struct OpenChallenge {
    Challenge challenge;
    std::uint64_t source = 0;
    hal::TimeNs until_ns = 0;
    hal::TimeNs sent_ns = 0;
    bool is_open = false;
  };
  void close_expired(hal::TimeNs now_ns);

  RateLimit limit_;
  std::array<OpenChallenge, kMostOpen> open_{};
};

}  // namespace g3d::net
