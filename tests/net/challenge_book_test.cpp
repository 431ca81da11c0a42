// SPDX-License-Identifier: Apache-2.0
#include "net/challenge_book.hpp"

#include <catch2/catch.hpp>
#include <set>

namespace {

using namespace g3d;
using namespace g3d::net;

constexpr hal::TimeNs kMs = hal::kMillisecond_ns;
constexpr RateLimits kNoLimit{.per_source = {1e6, 1e6}, .overall = {1e6, 1e6}};

std::uint64_t nonce_of(const std::variant<Challenge, GateRefusal>& asked) {
  REQUIRE(std::holds_alternative<Challenge>(asked));
  return std::get<Challenge>(asked).nonce;
}

bool refused(const std::variant<Challenge, GateRefusal>& asked, GateRefusal reason) {
  return std::holds_alternative<GateRefusal>(asked) && std::get<GateRefusal>(asked) == reason;
}

TEST_CASE("a challenge is redeemed once, by the session that was asked, in time") {
  ChallengeBook book;
  const auto asked = book.ask(7, 1, 0);
  const std::uint64_t nonce = nonce_of(asked);
  CHECK(std::get<Challenge>(asked).session == 7);
  CHECK_FALSE(book.redeem(nonce, 8, 0));
  CHECK_FALSE(book.redeem(nonce + 1, 7, 0));
  CHECK(book.redeem(nonce, 7, 1999 * kMs));
  CHECK_FALSE(book.redeem(nonce, 7, 1999 * kMs));
  const std::uint64_t late = nonce_of(book.ask(7, 1, 3000 * kMs));
  CHECK_FALSE(book.redeem(late, 7, 5000 * kMs));
}

TEST_CASE("nonces differ") {
  ChallengeBook book(kNoLimit);
  std::set<std::uint64_t> nonces;
  for (std::uint64_t i = 0; i < 50; ++i) nonces.insert(nonce_of(book.ask(i, 1, 0)));
  CHECK(nonces.size() == 50);
}

TEST_CASE("a challenge that was lost is sent again, but no longer than it is open") {
  ChallengeBook book;
  const std::uint64_t nonce = nonce_of(book.ask(7, 1, 0));
  CHECK(refused(book.ask(7, 1, 249 * kMs), GateRefusal::unproven));
  CHECK(nonce_of(book.ask(7, 1, 250 * kMs)) == nonce);
  CHECK(refused(book.ask(7, 1, 300 * kMs), GateRefusal::unproven));
  CHECK(nonce_of(book.ask(7, 1, 1900 * kMs)) == nonce);
  CHECK_FALSE(book.redeem(nonce, 7, 2000 * kMs));
  CHECK(nonce_of(book.ask(7, 1, 2000 * kMs)) != nonce);
}

TEST_CASE("who replays a session from elsewhere does not keep it from being asked") {
  ChallengeBook book;
  const std::uint64_t theirs = nonce_of(book.ask(7, 666, 0));
  const std::uint64_t ours = nonce_of(book.ask(7, 1, 0));
  CHECK(ours != theirs);
  CHECK(book.redeem(ours, 7, 0));
  CHECK_FALSE(book.redeem(theirs, 7, 0));
}

TEST_CASE("one source makes us ask a few times a second, and takes nothing from others") {
  ChallengeBook book;
  int asked = 0, others = 0;
  for (int ms = 0; ms < 10'000; ++ms) {
    asked += std::holds_alternative<Challenge>(book.ask(static_cast<std::uint64_t>(ms), 666, ms * kMs)) ? 1 : 0;
    if (ms % 500 == 0) others += std::holds_alternative<Challenge>(book.ask(1'000'000, 1, ms * kMs)) ? 1 : 0;
  }
  CHECK(asked == Approx(43).margin(1));
  CHECK(others == 20);
}

TEST_CASE("all sources together make us ask a bounded number of times, and the book never fills") {
  ChallengeBook book;
  int asked = 0;
  for (int ms = 0; ms < 10'000; ++ms) {
    const auto source = static_cast<std::uint64_t>(ms);
    asked += std::holds_alternative<Challenge>(book.ask(source, source, ms * kMs)) ? 1 : 0;
  }
  CHECK(asked == Approx(191).margin(2));
}

TEST_CASE("a full book asks no more until challenges have expired") {
  ChallengeBook book(kNoLimit);
  for (std::uint64_t i = 0; i < ChallengeBook::kMostOpen; ++i) (void)nonce_of(book.ask(i, i, 0));
  CHECK(refused(book.ask(1000, 1000, 1999 * kMs), GateRefusal::challenge_rate));
  CHECK(std::holds_alternative<Challenge>(book.ask(1000, 1000, 2000 * kMs)));
}

}  // namespace
