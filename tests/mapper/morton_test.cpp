// SPDX-License-Identifier: Apache-2.0
#include "mapper/morton.hpp"

#include <catch2/catch.hpp>
#include <random>

using namespace g3d::mapper;

namespace {

/// One bit at a time.
MCode slow_encode(const VoxelIndex& v) {
  MCode m = 0;
  for (int bit = 0; bit < kAxisBits; ++bit) {
    m |= static_cast<MCode>((v.x >> bit) & 1) << (3 * bit);
    m |= static_cast<MCode>((v.y >> bit) & 1) << (3 * bit + 1);
    m |= static_cast<MCode>((v.z >> bit) & 1) << (3 * bit + 2);
  }
  return m;
}

}  // namespace

TEST_CASE("the thesis's example has the thesis's octal digits") {
  const MCode m = encode({32794, 32808, 32776});
  const int expected[16] = {7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 1, 7, 0, 1, 0};
  for (int depth = 1; depth <= 16; ++depth) CHECK(octal_digit(m, depth) == expected[depth - 1]);
  CHECK(m < (MCode{1} << 48));
}

TEST_CASE("all 2^16 values of each axis survive the way there and back") {
  int wrong = 0;
  for (std::int32_t k = 0; k < kAxisCells; ++k) {
    const VoxelIndex x{k, 0, 0};
    const VoxelIndex y{65535, k, 0};
    const VoxelIndex z{0, 65535, k};
    for (const VoxelIndex& v : {x, y, z}) wrong += decode(encode(v)) == v && encode(v) == slow_encode(v) ? 0 : 1;
    wrong += collect_bits(spread_bits(static_cast<std::uint64_t>(k))) == static_cast<std::uint32_t>(k) ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("random codes and random voxels survive the way there and back") {
  std::mt19937_64 random(1);
  int wrong = 0;
  for (int i = 0; i < 200000; ++i) {
    const std::uint64_t bits = random();
    const VoxelIndex v{static_cast<std::int32_t>(bits & 0xFFFF), static_cast<std::int32_t>((bits >> 16) & 0xFFFF),
                       static_cast<std::int32_t>((bits >> 32) & 0xFFFF)};
    wrong += decode(encode(v)) == v && encode(v) == slow_encode(v) ? 0 : 1;
    const MCode m = random() & ((MCode{1} << 48) - 1);
    wrong += encode(decode(m)) == m ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("M >> 3k is the ancestor k levels up") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 2000; ++i) {
    const MCode m = random() & ((MCode{1} << 48) - 1);
    const VoxelIndex v = decode(m);
    for (int k = 0; k <= kAxisBits; ++k) REQUIRE((m >> (3 * k)) == encode({v.x >> k, v.y >> k, v.z >> k}));
  }
}

TEST_CASE("a block is the cube of 8 x 8 x 8 voxels that share M >> 9") {
  std::mt19937_64 random(3);
  for (int i = 0; i < 2000; ++i) {
    const VoxelIndex v = decode(random() & ((MCode{1} << 48) - 1));
    const BlockKey key = block_of(v);
    const VoxelIndex origin = block_origin(key);
    REQUIRE(origin == VoxelIndex{v.x & ~7, v.y & ~7, v.z & ~7});
    const VoxelIndex place = decode(encode(v) & kPlaceMask);
    REQUIRE(place == VoxelIndex{v.x & 7, v.y & 7, v.z & 7});
  }
}
