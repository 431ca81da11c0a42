// SPDX-License-Identifier: Apache-2.0
#include "net/challenge_book.hpp"

#include "net/secret_key.hpp"

namespace g3d::net {
namespace {

constexpr std::size_t kChallengedSources = 128;

}  // namespace

ChallengeBook::ChallengeBook(const RateLimits& limits) : limit_(limits, kChallengedSources) {}

void ChallengeBook::close_expired(hal::TimeNs now_ns) {
  for (OpenChallenge& open : open_) {
    if (open.is_open && now_ns >= open.until_ns) open.is_open = false;
  }
}

std::variant<Challenge, GateRefusal> ChallengeBook::ask(std::uint64_t session, std::uint64_t source,
                                                        hal::TimeNs now_ns) {
  close_expired(now_ns);
  OpenChallenge* free = nullptr;
  OpenChallenge* asked = nullptr;
  for (OpenChallenge& open : open_) {
    if (!open.is_open) free = &open;
    if (open.is_open && open.challenge.session == session && open.source == source) asked = &open;
  }
  if (asked != nullptr && now_ns - asked->sent_ns < kAskAgainAfter_ns) return GateRefusal::unproven;
  if (asked == nullptr && free == nullptr) return GateRefusal::challenge_rate;
  if (limit_.admit(source, RateClass::stranger, now_ns) != RateVerdict::admitted) return GateRefusal::challenge_rate;
  if (asked == nullptr) {
    asked = free;
    *asked = {{random_u64(), session}, source, now_ns + kAnswerWithin_ns, now_ns, true};
  }
  asked->sent_ns = now_ns;
  return asked->challenge;
}

bool ChallengeBook::redeem(std::uint64_t nonce, std::uint64_t session, hal::TimeNs now_ns) {
  close_expired(now_ns);
  bool was_asked = false;
  for (const OpenChallenge& open : open_) was_asked |= open.is_open && open.challenge == Challenge{nonce, session};
  if (!was_asked) return false;
  for (OpenChallenge& open : open_) open.is_open &= open.challenge.session != session;
  return true;
}

}  // namespace g3d::net
