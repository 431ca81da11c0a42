// SPDX-License-Identifier: Apache-2.0
#include "net/datagram_gate.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "tests/support/gate_fleet.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;
using namespace g3d::test;

constexpr hal::TimeNs kMs = hal::kMillisecond_ns;

DatagramBytes flipped(DatagramBytes datagram, std::uint64_t bit) {
  bit %= datagram.size() * 8;
  datagram[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
  return datagram;
}

TEST_CASE("the first datagram of a robot proves it, the next ones come through, each way by itself") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  CHECK_FALSE(air.say(a, b, "hello", 0));
  CHECK(b.gate.sessions().size() == 1);
  CHECK(a.gate.sessions().empty());
  CHECK(air.say(a, b, "hello again", 0) == "hello again");
  CHECK_FALSE(air.say(b, a, "yes", 0));
  CHECK(air.say(b, a, "yes?", 0) == "yes?");
  const GateCounts counts = b.gate.counts();
  CHECK(counts.challenged == 1);
  CHECK(counts.proven == 1);
  CHECK(counts.delivered == 1);
  CHECK(counts.answered == 1);
  CHECK(counts.refused() == 0);
  const DatagramBytes datagram = seal_text(a, "", 0);
  const GateTaken taken = b.gate.take(datagram, a.source, 0);
  CHECK(taken.verdict == GateVerdict::deliver);
  CHECK(taken.robot == 1);
  CHECK(taken.incarnation == 41);
  CHECK(taken.plaintext.empty());
}

TEST_CASE("100'000 forged, cut, flipped, replayed and foreign datagrams: none comes through, every one is counted") {
  const FleetKey keys = generate_fleet_key(), foreign_keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2), foreign(foreign_keys, 3);
  Air air;
  (void)air.say(a, b, "hello", 0);
  std::vector<DatagramBytes> good;
  for (int i = 0; i < 200; ++i) {
    good.push_back(seal_text(a, std::string(static_cast<std::size_t>(i * 5), 'x'), 0));
    REQUIRE(air.carry(a, b, good.back(), i * kMs));
  }
  std::mt19937_64 random(1);
  const GateCounts before = b.gate.counts();
  constexpr std::uint64_t kAttacks = 100'000;
  std::uint64_t said = 0;
  for (std::uint64_t i = 0; i < kAttacks; ++i) {
    DatagramBytes datagram = good[random() % good.size()];
    switch (i % 5) {
      case 0:  // forged: noise behind a header that is right
        for (std::size_t at = 15; at < datagram.size(); ++at) datagram[at] = static_cast<std::uint8_t>(random());
        break;
      case 1:
        datagram.resize(random() % datagram.size());
        break;
      case 2:
        datagram = flipped(std::move(datagram), random());
        break;
      case 3:  // replayed
        break;
      default:
        datagram = seal_text(foreign, "hello", 0);
    }
    // From ever new sources and with time between them, so that it is not the rate that stops them.
    const hal::TimeNs now_ns = static_cast<hal::TimeNs>(1000 + i) * kMs;
    const GateTaken taken = b.gate.take(datagram, 1'000'000 + i, now_ns);
    REQUIRE(taken.verdict == GateVerdict::refused);
    REQUIRE(taken.plaintext.empty());
    if (i % 500 != 499) continue;
    REQUIRE(air.say(a, b, "still here", now_ns) == "still here");
    ++said;
  }
  const GateCounts after = b.gate.counts();
  CHECK(after.delivered - before.delivered == said);
  CHECK(after.refused() - before.refused() == kAttacks);
  CHECK(after.proven_again == 10);
  CHECK(after.taken() - before.taken() == kAttacks + said + after.proven_again);
  CHECK(after[GateRefusal::replayed] == kAttacks / 5);
  CHECK(after[GateRefusal::forged] > kAttacks / 2);
  CHECK(after[GateRefusal::too_short] > 0);
  CHECK(after[GateRefusal::unknown_format] > 0);
  CHECK(after[GateRefusal::unknown_epoch] > 0);
}

TEST_CASE("what was recorded before a receiver's restart does not come through after it") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  for (int i = 0; i < 500; ++i) {
    (void)air.say(a, b, "from a", i * kMs);
    (void)air.say(b, a, "from b", i * kMs);
  }
  const std::vector<DatagramBytes> recorded = air.heard;
  const auto replay = [&](GateRobot& to, GateRobot* answering) {
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      const hal::TimeNs now_ns = static_cast<hal::TimeNs>(10'000 + 100 * i) * kMs;
      const GateTaken taken = to.gate.take(recorded[i], 666, now_ns);
      REQUIRE(taken.verdict != GateVerdict::deliver);
      if (taken.verdict != GateVerdict::answer || answering == nullptr) continue;
      // Whoever replays may also hand our challenges on.
      const DatagramBytes challenge(taken.answer.begin(), taken.answer.end());
      const GateTaken answer = answering->gate.take(challenge, 666, now_ns);
      REQUIRE(answer.verdict != GateVerdict::deliver);
      if (answer.verdict != GateVerdict::answer) continue;
      const DatagramBytes response(answer.answer.begin(), answer.answer.end());
      REQUIRE(to.gate.take(response, 666, now_ns).verdict != GateVerdict::deliver);
    }
  };
  SECTION("with nobody to answer") {
    GateRobot restarted(keys, 2);
    replay(restarted, nullptr);
    CHECK(restarted.gate.counts().delivered == 0);
    CHECK(restarted.gate.sessions().empty());
  }
  SECTION("with the sender still there, who is made known by it and no more") {
    GateRobot restarted(keys, 2);
    replay(restarted, &a);
    CHECK(restarted.gate.counts().delivered == 0);
    CHECK(restarted.gate.sessions().size() == 1);
    CHECK_FALSE(air.say(a, restarted, "who?", 500'000 * kMs));
    CHECK(air.say(a, restarted, "now", 500'000 * kMs) == "now");
  }
  SECTION("with the sender restarted as well, who does not answer for its old session") {
    GateRobot restarted(keys, 2), sender(keys, 1);
    replay(restarted, &sender);
    CHECK(restarted.gate.counts().delivered == 0);
    CHECK(restarted.gate.sessions().empty());
    CHECK(sender.gate.counts()[GateRefusal::foreign_challenge] > 0);
  }
  SECTION("sent back to who sent it") {
    replay(a, nullptr);
    CHECK(a.gate.counts()[GateRefusal::own_session] > 0);
  }
}

TEST_CASE("a robot that restarts is known again by its next two datagrams") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  (void)air.say(a, b, "x", 0);
  GateRobot again(keys, 1);
  CHECK_FALSE(air.say(again, b, "y", 100 * kMs));
  CHECK(air.say(again, b, "z", 100 * kMs) == "z");
  CHECK(b.gate.counts().superseded == 1);
  CHECK_FALSE(air.say(a, b, "ghost", 100 * kMs));
}

TEST_CASE("datagrams that were kept from us and come later are not delivered, however slowly they are handed over") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  (void)air.say(a, b, "x", 0);
  std::vector<DatagramBytes> kept;
  for (int i = 0; i < 900; ++i) kept.push_back(seal_text(a, "x", 0));  // one each 100 ms
  const bool asks_sender = GENERATE(false, true);
  hal::TimeNs latest_delay_ns = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const hal::TimeNs sent_ns = static_cast<hal::TimeNs>(i) * 100 * kMs, now_ns = 3 * sent_ns;
    const GateTaken taken = b.gate.take(kept[i], a.source, now_ns);
    if (taken.verdict == GateVerdict::deliver) latest_delay_ns = std::max(latest_delay_ns, now_ns - sent_ns);
    if (taken.answer.empty() || !asks_sender) continue;
    const DatagramBytes challenge(taken.answer.begin(), taken.answer.end());
    (void)air.carry(b, a, challenge, now_ns);
  }
  CHECK(latest_delay_ns > 5'000 * kMs);
  CHECK(latest_delay_ns < SessionTable::kProvenFor_ns);
  if (asks_sender) {
    CHECK(latest_delay_ns < SessionTable::kProveAgainAfter_ns);
    CHECK(b.gate.counts()[GateRefusal::replayed] > 800);
  }
}

TEST_CASE("robots that go on talking lose nothing by proving themselves again") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  (void)air.say(a, b, "x", 0);
  for (int i = 1; i < 6000; ++i) REQUIRE(air.say(a, b, "x", i * 100 * kMs));
  CHECK(b.gate.counts().proven_again == 59);
  CHECK(b.gate.counts().expired == 0);
  CHECK(b.gate.counts().refused() == 0);
  CHECK_FALSE(air.say(a, b, "after a silence", 700'000 * kMs));
  CHECK(b.gate.counts().expired == 1);
  CHECK(air.say(a, b, "x", 700'000 * kMs));
}

TEST_CASE("datagrams out of order come through, each once") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  (void)air.say(a, b, "x", 0);
  std::vector<DatagramBytes> sent;
  for (int i = 0; i < 1000; ++i) sent.push_back(seal_text(a, "x", 0));
  std::shuffle(sent.begin(), sent.end(), std::mt19937(1));
  for (const DatagramBytes& datagram : sent) CHECK(air.carry(a, b, datagram, 0));
  for (const DatagramBytes& datagram : sent) CHECK_FALSE(air.carry(a, b, datagram, 1000 * kMs));
}

TEST_CASE("a flood from one source leaves others alone, whatever it is made of") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  (void)air.say(a, b, "x", 0);
  const DatagramBytes copied = seal_text(a, "copied", 0);
  REQUIRE(air.carry(a, b, copied, 0));
  DatagramBytes noise = flipped(copied, 200);
  SECTION("forged with a robot's own session") {}
  SECTION("forged with another session") { noise[5] ^= 1; }
  SECTION("recorded") { noise = copied; }
  int heard = 0;
  for (int ms = 0; ms < 2000; ++ms) {
    for (int i = 0; i < 20; ++i) (void)b.gate.take(noise, 666, ms * kMs);
    if (ms % 10 == 0) heard += air.say(a, b, "x", ms * kMs) ? 1 : 0;
  }
  CHECK(heard == 200);
  const GateCounts counts = b.gate.counts();
  CHECK(counts[GateRefusal::source_rate] + counts[GateRefusal::overall_rate] > 30'000);
  if (noise != copied) CHECK(counts[GateRefusal::forged] < 60);
}

TEST_CASE("who forges a robot's address does not silence it") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  (void)air.say(a, b, "x", 0);
  const DatagramBytes noise(100, 0x30);
  int heard = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    DatagramBytes datagram = noise;
    datagram[1] = 1;
    for (int i = 0; i < 20; ++i) (void)b.gate.take(datagram, a.source, ms * kMs);
    heard += air.say(a, b, "x", ms * kMs) ? 1 : 0;
  }
  CHECK(heard == 1000);
}

TEST_CASE("who forges a robot's address and its session as well does not silence it, unless by thousands a second") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  (void)air.say(a, b, "x", 0);
  const DatagramBytes noise = flipped(seal_text(a, "x", 0), 200);
  const int per_ms = GENERATE(3, 50);
  int heard = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    for (int i = 0; i < per_ms; ++i) (void)b.gate.take(noise, a.source, ms * kMs);
    heard += air.say(a, b, "x", ms * kMs) ? 1 : 0;
  }
  if (per_ms == 3) CHECK(heard == 1000);
  // And what he can make us open is bounded.
  CHECK(b.gate.counts()[GateRefusal::forged] <= 5000);
}

TEST_CASE("a flood from many sources costs a bounded number of decryptions, and known robots go on") {
  const FleetKey keys = generate_fleet_key(), foreign_keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2), foreign(foreign_keys, 3);
  Air air;
  (void)air.say(a, b, "x", 0);
  const DatagramBytes noise = seal_text(foreign, "x", 0);
  int heard = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    for (std::uint64_t i = 0; i < 100; ++i) {
      (void)b.gate.take(noise, 1'000'000 + static_cast<std::uint64_t>(ms) * 100 + i, ms * kMs);
    }
    heard += air.say(a, b, "x", ms * kMs) ? 1 : 0;
  }
  CHECK(heard == 1000);
  CHECK(b.gate.counts()[GateRefusal::forged] < 2600);
}

TEST_CASE("sessions are evicted and come back by a challenge") {
  const FleetKey keys = generate_fleet_key();
  GateRobot listener(keys, 100, 3);
  std::vector<std::unique_ptr<GateRobot>> robots;
  Air air;
  for (std::uint64_t i = 0; i < 4; ++i) {
    robots.push_back(std::make_unique<GateRobot>(keys, i));
    (void)air.say(*robots.back(), listener, "x", static_cast<hal::TimeNs>(i) * kMs);
  }
  CHECK(listener.gate.counts().evicted == 1);
  CHECK(listener.gate.sessions().size() == 3);
  CHECK(air.say(*robots[3], listener, "x", 10 * kMs) == "x");
  const DatagramBytes recorded = seal_text(*robots[0], "recorded", 10 * kMs);
  CHECK_FALSE(air.carry(*robots[0], listener, recorded, 1000 * kMs));
  CHECK(air.say(*robots[0], listener, "y", 1000 * kMs) == "y");
  CHECK(listener.gate.take(recorded, robots[0]->source, 1000 * kMs).reason == GateRefusal::replayed);
}

TEST_CASE("authentic handshakes that say nothing sensible are refused and counted") {
  const FleetKey keys = generate_fleet_key();
  GateRobot b(keys, 2);
  Sealer sealer;
  std::array<std::uint8_t, kMostDatagram_bytes> out;
  const auto reason = [&](std::span<const std::uint8_t> message, hal::TimeNs now_ns) {
    const auto sealed = sealer.seal({.handshake = true}, keys.epoch, keys.key, message, out);
    return b.gate.take(std::span(out).first(sealed.size_bytes), 5, now_ns).reason;
  };
  CHECK(reason({}, 0) == GateRefusal::malformed_handshake);
  CHECK(reason(encode(Response{1, 2, 3}), 0) == GateRefusal::stale_response);
  CHECK(reason(encode(Challenge{1, 2}), 0) == GateRefusal::foreign_challenge);
  for (int i = 0; i < 8; ++i) CHECK(reason(encode(Challenge{1, b.gate.own_session()}), 0) == GateRefusal::count_);
  CHECK(reason(encode(Challenge{1, b.gate.own_session()}), 0) == GateRefusal::answer_rate);
  CHECK(b.gate.counts().taken() == 12);
}

TEST_CASE("a message of the fleet cannot pass for a handshake, nor the other way round") {
  const FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  (void)air.say(a, b, "x", 0);
  const auto challenge = encode(Challenge{1, b.gate.own_session()});
  const std::string text(challenge.begin(), challenge.end());
  CHECK(air.say(a, b, text, 0) == text);
  DatagramBytes relabelled = seal_text(a, text, 0);
  relabelled[0] ^= 1;
  CHECK(b.gate.take(relabelled, a.source, 0).reason == GateRefusal::forged);
}

TEST_CASE("one who uses up its counters is silent, and says so") {
  const FleetKey keys = generate_fleet_key();
  DatagramGate gate(copy_of(keys), {.robot = 1}, {77, kMostCounter});
  CHECK(gate.seal({}, 0).verdict == SealVerdict::sealed);
  const auto sealed = gate.seal({}, 0);
  CHECK(sealed.verdict == SealVerdict::exhausted);
  CHECK(sealed.datagram.empty());
  CHECK(gate.counts().not_sealed == 1);
}

}  // namespace
