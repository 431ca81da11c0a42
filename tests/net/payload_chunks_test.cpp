// SPDX-License-Identifier: Apache-2.0
#include "net/payload_chunks.hpp"

#include <catch2/catch.hpp>
#include <iterator>
#include <map>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using mapper::Bytes;
using net::PayloadChunks;

namespace {

Bytes random_payload_bytes(tests::Random& random, std::size_t count) {
  Bytes bytes(count);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
  return bytes;
}

Bytes bytes_of_chain(const PayloadChunks& chunks, std::uint32_t chain, std::size_t count) {
  Bytes bytes(count);
  chunks.get(chain, bytes);
  return bytes;
}

/// How many strings of one byte find room.
std::size_t places_in(PayloadChunks& chunks) {
  std::vector<std::uint32_t> chains;
  std::uint32_t chain = 0;
  while (chunks.put(Bytes{1}, chain)) chains.push_back(chain);
  for (const std::uint32_t taken : chains) chunks.drop(taken);
  return chains.size();
}

}  // namespace

TEST_CASE("chunks of payload keep what a map of vectors keeps, and refuse only what does not fit", "[net]") {
  tests::Random random(7);
  PayloadChunks chunks(20000);
  const std::size_t places = places_in(chunks);
  REQUIRE(chunks.used_bytes() == 0);
  const std::size_t chunk_bytes = [&] {
    std::uint32_t chain = 0;
    REQUIRE(chunks.put(Bytes{1}, chain));
    const std::size_t used = chunks.used_bytes();
    chunks.drop(chain);
    return used;
  }();
  CHECK(places * chunk_bytes <= 20000);
  std::map<std::uint32_t, Bytes> plain;  // by chain
  int refused = 0;
  for (int step = 0; step < 20000; ++step) {
    const std::size_t used_before = chunks.used_bytes();
    if (random.below(100) < 55) {
      const Bytes bytes = random_payload_bytes(random, 1 + random.below(random.below(20) == 0 ? 1200 : 90));
      std::uint32_t chain = 0;
      if (chunks.put(bytes, chain)) {
        REQUIRE(chain != PayloadChunks::kNone);
        REQUIRE(plain.emplace(chain, bytes).second);
        REQUIRE(chunks.used_bytes() >= used_before + bytes.size());
      } else {
        ++refused;
        REQUIRE(chunks.used_bytes() == used_before);
        // It is true that it does not fit: less than five bytes of a chunk are not for the string.
        REQUIRE(places * chunk_bytes - used_before < (bytes.size() / (chunk_bytes - 4) + 1) * chunk_bytes);
      }
    } else if (!plain.empty()) {
      const auto which = std::next(plain.begin(), random.below(static_cast<std::uint32_t>(plain.size())));
      REQUIRE(bytes_of_chain(chunks, which->first, which->second.size()) == which->second);
      chunks.drop(which->first);
      REQUIRE(chunks.used_bytes() < used_before);
      plain.erase(which);
    }
  }
  CHECK(refused > 100);
  for (const auto& [chain, bytes] : plain) {
    REQUIRE(bytes_of_chain(chunks, chain, bytes.size()) == bytes);
    REQUIRE(chunks.equals(chain, bytes));
    chunks.drop(chain);
  }
  CHECK(chunks.used_bytes() == 0);
  CHECK(places_in(chunks) == places);
}

TEST_CASE("a payload of any length around the ends of chunks comes back as it was, and differs in every byte",
          "[net]") {
  tests::Random random(3);
  PayloadChunks chunks(100000);
  for (std::size_t count = 1; count <= 130; ++count) {
    INFO(count << " bytes");
    Bytes bytes = random_payload_bytes(random, count);
    std::uint32_t chain = 0;
    REQUIRE(chunks.put(bytes, chain));
    REQUIRE(bytes_of_chain(chunks, chain, count) == bytes);
    REQUIRE(chunks.equals(chain, bytes));
    for (std::size_t shorter = 0; shorter + 28 <= count; ++shorter) {
      REQUIRE_FALSE(chunks.equals(chain, mapper::ByteSpan(bytes).first(shorter)));
    }
    for (std::uint8_t& byte : bytes) {
      byte ^= 0x10U;
      REQUIRE_FALSE(chunks.equals(chain, bytes));
      byte ^= 0x10U;
    }
    chunks.drop(chain);
  }
  CHECK(chunks.used_bytes() == 0);
}

TEST_CASE("an empty payload takes no room, even where there is none", "[net]") {
  PayloadChunks chunks(0);
  std::uint32_t chain = 0;
  REQUIRE(chunks.put({}, chain));
  CHECK(chain == PayloadChunks::kNone);
  CHECK(chunks.used_bytes() == 0);
  CHECK(chunks.equals(chain, {}));
  CHECK_FALSE(chunks.equals(chain, Bytes{1}));
  chunks.get(chain, {});
  chunks.drop(chain);
  CHECK_FALSE(chunks.put(Bytes{1}, chain));
}

TEST_CASE("full chunks hold one payload of all their bytes and not one byte more", "[net]") {
  tests::Random random(4);
  PayloadChunks chunks(36 * 50);
  const std::size_t places = places_in(chunks);
  REQUIRE(places == 50);
  const Bytes most = random_payload_bytes(random, 28 * places);
  std::uint32_t chain = 0;
  CHECK_FALSE(chunks.put(random_payload_bytes(random, most.size() + 1), chain));
  CHECK(chunks.used_bytes() == 0);
  REQUIRE(chunks.put(most, chain));
  CHECK(chunks.used_bytes() == 32 * places);
  std::uint32_t other = 0;
  CHECK_FALSE(chunks.put(Bytes{9}, other));
  CHECK(bytes_of_chain(chunks, chain, most.size()) == most);
  chunks.drop(chain);
  CHECK(chunks.used_bytes() == 0);
}

TEST_CASE("chunks say whether there is room once something was dropped", "[net]") {
  PayloadChunks chunks(3 * 36);
  std::uint32_t chain = 0;
  REQUIRE(chunks.put(Bytes(56, 1), chain));
  CHECK(chunks.has_room_for(28, 0));
  CHECK_FALSE(chunks.has_room_for(29, 0));
  CHECK(chunks.has_room_for(84, 56));
  CHECK_FALSE(chunks.has_room_for(85, 56));
  CHECK(chunks.has_room_for(56, 28));
}
