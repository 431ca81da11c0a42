// SPDX-License-Identifier: Apache-2.0
#include "net/session_table.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

namespace {

using namespace g3d;
using namespace g3d::net;

constexpr hal::TimeNs kMs = hal::kMillisecond_ns;
constexpr RateLimits kNoLimit{.per_source = {1e6, 1e6}, .overall = {1e6, 1e6}};
constexpr OwnIdentity kOwn{100, 1, 5};

std::optional<GateRefusal> prove(SessionTable& table, std::uint64_t session, std::uint64_t robot, hal::TimeNs now_ns,
                                 std::uint64_t counter = 0) {
  const auto asked = table.challenge(session, 9, now_ns);
  REQUIRE(std::holds_alternative<Challenge>(asked));
  return table.prove(session, counter, {std::get<Challenge>(asked).nonce, robot, 3}, 9, now_ns);
}

TEST_CASE("a session is known once it has answered, with what it said") {
  SessionTable table(kOwn, 4);
  CHECK(table.find(200, 0) == nullptr);
  CHECK_FALSE(prove(table, 200, 2, 50 * kMs, 10));
  const KnownSession* const known = table.find(200, 0);
  REQUIRE(known != nullptr);
  CHECK(known->robot == 2);
  CHECK(known->incarnation == 3);
  CHECK(known->source == 9);
  CHECK(known->heard_ns == 50 * kMs);
  CHECK(table.known().size() == 1);
}

TEST_CASE("what was sent before the response is never fresh, what comes after it is once") {
  SessionTable table(kOwn, 4);
  REQUIRE_FALSE(prove(table, 200, 2, 0, 10));
  KnownSession& known = *table.find(200, 0);
  for (std::uint64_t counter = 0; counter <= 10; ++counter) {
    CHECK(table.take(known, counter, 9, 0) == GateRefusal::replayed);
  }
  CHECK_FALSE(table.take(known, 11, 77, 5 * kMs));
  CHECK(known.source == 77);
  CHECK(known.heard_ns == 5 * kMs);
  CHECK(table.take(known, 11, 78, 6 * kMs) == GateRefusal::replayed);
  CHECK(known.source == 77);
  CHECK_FALSE(table.take(known, 3000, 9, 0));
  CHECK(table.take(known, 100, 9, 0) == GateRefusal::too_old);
}

TEST_CASE("a response that answers nothing, or for another session, proves nothing") {
  SessionTable table(kOwn, 4);
  CHECK(table.prove(200, 0, {1, 2, 3}, 9, 0) == GateRefusal::stale_response);
  const auto asked = std::get<Challenge>(table.challenge(200, 9, 0));
  CHECK(table.prove(201, 0, {asked.nonce, 2, 3}, 9, 0) == GateRefusal::stale_response);
  CHECK(table.prove(200, 0, {asked.nonce, 2, 3}, 9, 2000 * kMs) == GateRefusal::stale_response);
  CHECK(table.known().empty());
}

TEST_CASE("we are not our own company") {
  SessionTable table(kOwn, 4);
  CHECK(std::get<GateRefusal>(table.challenge(kOwn.session, 9, 0)) == GateRefusal::own_session);
  CHECK(table.prove(kOwn.session, 0, {0, 2, 3}, 9, 0) == GateRefusal::own_session);
  CHECK(prove(table, 200, kOwn.robot, 0) == GateRefusal::same_robot);
  CHECK(table.known().empty());
}

TEST_CASE("the revoked do not get in, and those who are in get out") {
  SessionTable table(kOwn, 4, kNoLimit);
  for (const std::uint64_t robot : {2U, 3U, 4U}) REQUIRE_FALSE(prove(table, 200 + robot, robot, 0));
  const std::vector<std::uint64_t> revoked{3};
  table.use_revoked(revoked);
  CHECK(table.find(203, 20 * kMs) == nullptr);
  CHECK(table.find(202, 20 * kMs) != nullptr);
  CHECK(table.find(204, 20 * kMs) != nullptr);
  CHECK(prove(table, 203, 3, 0) == GateRefusal::revoked);
  table.use_revoked({});
  CHECK_FALSE(prove(table, 203, 3, 3000 * kMs));
}

TEST_CASE("of more than fit, the one that was silent longest goes") {
  SessionTable table(kOwn, 3, kNoLimit);
  for (const std::uint64_t robot : {2U, 3U, 4U}) {
    REQUIRE_FALSE(prove(table, 200 + robot, robot, static_cast<hal::TimeNs>(robot) * kMs));
  }
  CHECK_FALSE(table.take(*table.find(202, 20 * kMs), 1, 9, 10 * kMs));
  REQUIRE_FALSE(prove(table, 205, 5, 11 * kMs));
  CHECK(table.evicted() == 1);
  CHECK(table.find(203, 20 * kMs) == nullptr);
  for (const std::uint64_t session : {202U, 204U, 205U}) CHECK(table.find(session, 20 * kMs) != nullptr);
  CHECK(table.known().size() == 3);
}

TEST_CASE("a robot that starts again takes its own place, not another's") {
  SessionTable table(kOwn, 2, kNoLimit);
  REQUIRE_FALSE(prove(table, 202, 2, 0));
  REQUIRE_FALSE(prove(table, 203, 3, 0));
  REQUIRE_FALSE(prove(table, 303, 3, 1 * kMs));
  CHECK(table.superseded() == 1);
  CHECK(table.evicted() == 0);
  CHECK(table.find(203, 20 * kMs) == nullptr);
  CHECK(table.find(202, 20 * kMs) != nullptr);
  CHECK(table.find(303, 20 * kMs)->robot == 3);
}

TEST_CASE("a session has to prove itself again, and then nothing from before is fresh") {
  constexpr hal::TimeNs kAgain_ns = SessionTable::kProveAgainAfter_ns, kEnd_ns = SessionTable::kProvenFor_ns;
  SessionTable table(kOwn, 4, kNoLimit);
  REQUIRE_FALSE(prove(table, 200, 2, 0, 10));
  CHECK_FALSE(table.take(*table.find(200, 0), 20, 9, kAgain_ns));
  CHECK_FALSE(SessionTable::should_prove_again(*table.find(200, 0), kAgain_ns - 1));
  CHECK(SessionTable::should_prove_again(*table.find(200, 0), kAgain_ns));
  SECTION("it does") {
    REQUIRE_FALSE(prove(table, 200, 2, kAgain_ns, 30));
    KnownSession* const known = table.find(200, kAgain_ns + kEnd_ns - 1);
    REQUIRE(known != nullptr);
    CHECK(table.known().size() == 1);
    CHECK(table.superseded() == 0);
    CHECK_FALSE(SessionTable::should_prove_again(*known, kAgain_ns));
    CHECK(table.take(*known, 29, 9, kAgain_ns) == GateRefusal::replayed);
    CHECK_FALSE(table.take(*known, 31, 9, kAgain_ns));
  }
  SECTION("with a response that was seen before") {
    CHECK(prove(table, 200, 2, kAgain_ns, 20) == GateRefusal::replayed);
    CHECK(SessionTable::should_prove_again(*table.find(200, kAgain_ns), kAgain_ns));
  }
  SECTION("it does not") {
    CHECK(table.find(200, kEnd_ns - 1) != nullptr);
    CHECK(table.find(200, kEnd_ns) == nullptr);
    CHECK(table.expired() == 1);
    CHECK(table.known().empty());
  }
  SECTION("as another robot") {
    REQUIRE_FALSE(prove(table, 201, 3, 0));
    REQUIRE_FALSE(prove(table, 200, 3, kAgain_ns, 30));
    CHECK(table.known().size() == 1);
    CHECK(table.find(200, kAgain_ns)->robot == 3);
  }
}

TEST_CASE("a table of none holds one") {
  SessionTable table(kOwn, 0, kNoLimit);
  REQUIRE_FALSE(prove(table, 202, 2, 0));
  REQUIRE_FALSE(prove(table, 203, 3, 0));
  CHECK(table.known().size() == 1);
}

}  // namespace
