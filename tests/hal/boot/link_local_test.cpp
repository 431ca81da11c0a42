// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/link_local.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <vector>

using namespace g3d::hal;
using namespace g3d::hal::boot;

namespace {

constexpr MacAddress kMac = {0x52, 0x54, 0, 0x12, 0x34, 0x56}, kOtherMac = {0x52, 0x54, 0, 0x12, 0x34, 0x57};
constexpr TimeNs kSecond_ns = 1'000'000'000;

/// Until it says no more, or so many words.
std::vector<Arp> words_of(LinkLocal& local, TimeNs& now_ns, std::size_t most = 100) {
  std::vector<Arp> words;
  while (words.size() < most && local.next_ns() != INT64_MAX) {
    now_ns = local.next_ns();
    if (const auto word = local.on_time(now_ns)) words.push_back(*word);
  }
  return words;
}

}  // namespace

TEST_CASE("ARP packets are those of RFC 826, and nothing else is taken for one", "[boot]") {
  const Arp arp{true, kMac, 0, 0xA9FE0102};
  const ArpPacket packet = encode_arp(arp);
  const ArpPacket expected = {0, 1, 8, 0, 6, 4, 0, 1, 0x52, 0x54, 0,   0x12, 0x34, 0x56,
                              0, 0, 0, 0, 0, 0, 0, 0, 0,    0,    169, 254,  1,    2};
  CHECK(packet == expected);
  const auto back = decode_arp(packet);
  REQUIRE(back);
  CHECK(back->is_request);
  CHECK(back->sender_mac == kMac);
  CHECK(back->target_ipv4 == 0xA9FE0102);
  CHECK_FALSE(decode_arp({packet.data(), 27}));
  for (std::size_t i = 0; i < 7; ++i) {
    ArpPacket wrong = packet;
    wrong[i] ^= 0x40U;
    CHECK_FALSE(decode_arp(wrong));
  }
}

TEST_CASE("an address is asked for three times before it is used, and then announced twice", "[boot]") {
  LinkLocal local(kMac, 5 * kSecond_ns);
  TimeNs now_ns = 5 * kSecond_ns;
  CHECK_FALSE(local.on_time(now_ns - 1));
  std::vector<TimeNs> times;
  for (int i = 0; i < LinkLocal::kProbes; ++i) {
    now_ns = local.next_ns();
    times.push_back(now_ns);
    CHECK_FALSE(local.address());
    const auto probe = local.on_time(now_ns);
    REQUIRE(probe);
    CHECK(probe->is_request);
    CHECK(probe->sender_ipv4 == 0);
    CHECK(probe->target_ipv4 >= 0xA9FE0100);
    CHECK(probe->target_ipv4 <= 0xA9FEFEFF);
  }
  CHECK(times[0] - 5 * kSecond_ns <= LinkLocal::kProbePeriod_ns);
  for (int i = 1; i < 3; ++i) {
    CHECK(times[static_cast<std::size_t>(i)] - times[static_cast<std::size_t>(i - 1)] >= LinkLocal::kProbePeriod_ns);
    CHECK(times[static_cast<std::size_t>(i)] - times[static_cast<std::size_t>(i - 1)] <=
          2 * LinkLocal::kProbePeriod_ns);
  }
  CHECK_FALSE(local.address());
  const auto announced = words_of(local, now_ns);
  REQUIRE(announced.size() == 2);
  REQUIRE(local.address());
  for (const Arp& word : announced) {
    CHECK(word.sender_ipv4 == *local.address());
    CHECK(word.target_ipv4 == *local.address());
  }
  CHECK(local.next_ns() == INT64_MAX);
}

TEST_CASE("an address that somebody has, or asks for, is left for another one", "[boot]") {
  LinkLocal local(kMac, 0);
  TimeNs now_ns = 0;
  const auto first = words_of(local, now_ns, 1).front().target_ipv4;
  SECTION("it is in use") { CHECK_FALSE(local.on_arp({false, kOtherMac, first, 0}, now_ns)); }
  SECTION("another one asks for it") { CHECK_FALSE(local.on_arp({true, kOtherMac, 0, first}, now_ns)); }
  CHECK(local.conflicts() == 1);
  const auto words = words_of(local, now_ns);
  CHECK(words.size() == 5);
  CHECK(local.address() != first);
}

TEST_CASE("what is ours, or about other addresses, is no conflict", "[boot]") {
  LinkLocal local(kMac, 0);
  TimeNs now_ns = 0;
  const auto first = words_of(local, now_ns, 1).front().target_ipv4;
  (void)local.on_arp({true, kMac, 0, first}, now_ns);
  (void)local.on_arp({true, kOtherMac, first + 1, first}, now_ns);  // somebody asks who has it
  (void)local.on_arp({true, kOtherMac, 0, first + 1}, now_ns);
  (void)words_of(local, now_ns);
  CHECK(local.conflicts() == 0);
  CHECK(local.address() == first);
}

TEST_CASE("an address in use is defended once in ten seconds, and given up the second time", "[boot]") {
  LinkLocal local(kMac, 0);
  TimeNs now_ns = 0;
  (void)words_of(local, now_ns);
  const std::uint32_t first = local.address().value();
  const Arp claim{true, kOtherMac, first, first};
  const auto defence = local.on_arp(claim, now_ns);
  REQUIRE(defence);
  CHECK(defence->sender_ipv4 == first);
  const auto later = local.on_arp(claim, now_ns + LinkLocal::kDefend_ns);
  CHECK(later);
  CHECK_FALSE(local.on_arp(claim, now_ns + LinkLocal::kDefend_ns + kSecond_ns));
  CHECK_FALSE(local.address());
  (void)words_of(local, now_ns);
  CHECK(local.address() != first);
}

TEST_CASE("after ten conflicts it asks no more than once a minute", "[boot]") {
  LinkLocal local(kMac, 0);
  TimeNs now_ns = 0;
  for (int i = 0; i <= LinkLocal::kMostConflicts; ++i) {
    const auto probes = words_of(local, now_ns, 1);
    (void)local.on_arp({false, kOtherMac, probes.front().target_ipv4, 0}, now_ns);
  }
  CHECK(local.next_ns() - now_ns == LinkLocal::kRateLimit_ns);
}

TEST_CASE("different cards begin with different addresses, the same card always with the same", "[boot]") {
  std::set<std::uint32_t> firsts;
  for (std::uint8_t i = 0; i < 100; ++i) {
    MacAddress mac = kMac;
    mac[5] = i;
    TimeNs now_ns = 0;
    LinkLocal one(mac, 0), same(mac, 0);
    const auto first = words_of(one, now_ns, 1).front().target_ipv4;
    CHECK(words_of(same, now_ns, 1).front().target_ipv4 == first);
    firsts.insert(first);
  }
  CHECK(firsts.size() >= 98);
}
