// SPDX-License-Identifier: Apache-2.0
#include "net/datagram_seal.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace g3d::net;
using Bytes = std::vector<std::uint8_t>;

struct Bench {
  FleetKey keys = generate_fleet_key();
  Sealer sealer;
  Opener opener{keys};
  std::array<std::uint8_t, kMostDatagram_bytes> sealed_bytes, opened_bytes;

  Bytes seal(const Bytes& plaintext, DatagramKind kind = {}) {
    const auto sealed = sealer.seal(kind, keys.epoch, keys.key, plaintext, sealed_bytes);
    REQUIRE(sealed.verdict == SealVerdict::sealed);
    return {sealed_bytes.begin(), sealed_bytes.begin() + static_cast<std::ptrdiff_t>(sealed.size_bytes)};
  }
  OpenVerdict verdict(const Bytes& datagram) { return opener.open(datagram, opened_bytes).envelope.verdict; }
};

Bytes some_bytes(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + 3);
  return bytes;
}

TEST_CASE("an envelope weighs 31 bytes") {
  CHECK(kEnvelope_bytes == 31);
  CHECK(kMostPlaintext_bytes == 1169);
}

TEST_CASE("what is sealed opens, of every size and kind") {
  Bench bench;
  std::uint64_t counter = 0;
  for (std::size_t size = 0; size <= kMostPlaintext_bytes; size += size < 70 ? 1 : 157) {
    const DatagramKind kind{size % 2 == 1, size % 4 >= 2};
    const Bytes plaintext = some_bytes(size);
    const Bytes datagram = bench.seal(plaintext, kind);
    CHECK(datagram.size() == size + kEnvelope_bytes);
    const auto opened = bench.opener.open(datagram, bench.opened_bytes);
    REQUIRE(opened.envelope.verdict == OpenVerdict::opened);
    CHECK(std::equal(plaintext.begin(), plaintext.end(), opened.plaintext.begin(), opened.plaintext.end()));
    CHECK(opened.envelope.kind.handshake == kind.handshake);
    CHECK(opened.envelope.kind.holds_newer == kind.holds_newer);
    CHECK(opened.envelope.session == bench.sealer.session());
    CHECK(opened.envelope.counter == counter++);
    CHECK_FALSE(opened.envelope.previous_epoch);
  }
  const Bytes largest = bench.seal(some_bytes(kMostPlaintext_bytes));
  CHECK(largest.size() == kMostDatagram_bytes);
  CHECK(bench.verdict(largest) == OpenVerdict::opened);
}

TEST_CASE("too much to seal is refused and uses no counter") {
  Bench bench;
  const auto sealed =
      bench.sealer.seal({}, 1, bench.keys.key, some_bytes(kMostPlaintext_bytes + 1), bench.sealed_bytes);
  CHECK(sealed.verdict == SealVerdict::too_long);
  CHECK(bench.sealer.next_counter() == 0);
}

TEST_CASE("a counter is used once, and the last one ends the session") {
  Bench bench;
  Sealer last({5, kMostCounter - 1});
  const auto seal = [&] { return last.seal({}, 1, bench.keys.key, some_bytes(3), bench.sealed_bytes); };
  for (int i = 0; i < 2; ++i) {
    const auto sealed = seal();
    REQUIRE(sealed.verdict == SealVerdict::sealed);
    const auto opened = bench.opener.open(std::span(bench.sealed_bytes).first(sealed.size_bytes), bench.opened_bytes);
    CHECK(opened.envelope.verdict == OpenVerdict::opened);
    CHECK(opened.envelope.counter == kMostCounter - 1 + static_cast<std::uint64_t>(i));
  }
  for (int i = 0; i < 10; ++i) CHECK(seal().verdict == SealVerdict::exhausted);
}

TEST_CASE("senders draw sessions of their own") {
  const Sealer a, b;
  CHECK(a.session() != b.session());
}

TEST_CASE("the same text never looks the same, and is never to be seen") {
  Bench bench;
  const std::string secret = "the robot is in the kitchen";
  const Bytes plaintext(secret.begin(), secret.end());
  const Bytes a = bench.seal(plaintext), b = bench.seal(plaintext);
  CHECK(Bytes(a.begin() + 15, a.end()) != Bytes(b.begin() + 15, b.end()));
  for (int i = 0; i < 1000; ++i) {
    const Bytes sealed = bench.seal(plaintext);
    for (std::size_t at = 0; at + 4 <= plaintext.size(); ++at) {
      REQUIRE(std::search(sealed.begin(), sealed.end(), plaintext.begin() + static_cast<std::ptrdiff_t>(at),
                          plaintext.begin() + static_cast<std::ptrdiff_t>(at + 4)) == sealed.end());
    }
  }
}

TEST_CASE("every bit counts") {
  Bench bench;
  const Bytes good = bench.seal(some_bytes(20));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes flipped = good;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    const OpenVerdict expected = bit >= 2 && bit < 8    ? OpenVerdict::unknown_format
                                 : bit >= 8 && bit < 16 ? OpenVerdict::unknown_epoch
                                                        : OpenVerdict::forged;
    REQUIRE(bench.verdict(flipped) == expected);
  }
  CHECK(bench.verdict(good) == OpenVerdict::opened);
}

TEST_CASE("every length but the right one is refused") {
  Bench bench;
  const Bytes good = bench.seal(some_bytes(100));
  for (std::size_t size = 0; size <= kMostDatagram_bytes + 2; ++size) {
    Bytes other = good;
    other.resize(size);
    const OpenVerdict expected = size < 31                    ? OpenVerdict::too_short
                                 : size > kMostDatagram_bytes ? OpenVerdict::too_long
                                 : size == good.size()        ? OpenVerdict::opened
                                                              : OpenVerdict::forged;
    REQUIRE(bench.verdict(other) == expected);
  }
}

TEST_CASE("what is forged leaves nothing behind") {
  Bench bench;
  Bytes datagram = bench.seal(Bytes(500, 0xAB));
  datagram.back() ^= 1;
  bench.opened_bytes.fill(0xAB);
  const auto opened = bench.opener.open(datagram, bench.opened_bytes);
  CHECK(opened.plaintext.empty());
  CHECK(std::count(bench.opened_bytes.begin(), bench.opened_bytes.begin() + 500, 0xAB) == 0);
}

TEST_CASE("a key opens its own epoch alone") {
  Bench bench;
  const Bytes old = bench.seal(some_bytes(9));
  rotate_fleet_key(bench.keys, OldKey::kept_until_finished);
  const auto opened = bench.opener.open(old, bench.opened_bytes);
  CHECK(opened.envelope.verdict == OpenVerdict::opened);
  CHECK(opened.envelope.previous_epoch);
  Bytes relabelled = old;
  relabelled[1] = static_cast<std::uint8_t>(bench.keys.epoch);
  CHECK(bench.verdict(relabelled) == OpenVerdict::forged);
  const Bytes fresh = bench.seal(some_bytes(9));
  CHECK_FALSE(bench.opener.look(fresh).previous_epoch);
  finish_rotation(bench.keys);
  CHECK(bench.verdict(old) == OpenVerdict::unknown_epoch);
  CHECK(bench.verdict(fresh) == OpenVerdict::opened);
  Bench foreign;
  CHECK(foreign.verdict(old) == OpenVerdict::forged);
}

TEST_CASE("epochs tell apart where their number begins anew") {
  Bench bench;
  bench.keys.epoch = 65535;
  const Bytes old = bench.seal(some_bytes(1));
  rotate_fleet_key(bench.keys, OldKey::kept_until_finished);
  CHECK(bench.opener.look(old).previous_epoch);
  CHECK(bench.verdict(old) == OpenVerdict::opened);
}

}  // namespace
