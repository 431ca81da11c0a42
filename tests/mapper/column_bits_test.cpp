// SPDX-License-Identifier: Apache-2.0
#include "mapper/column_bits.hpp"

#include <catch2/catch.hpp>

using namespace g3d::mapper;

TEST_CASE("joining bits does not depend on the order, and counts up to two", "[long]") {
  for (std::uint32_t a = 0; a < 256; ++a) {
    for (std::uint32_t b = 0; b < 256; ++b) {
      REQUIRE(joined_bits(a, b) == joined_bits(b, a));
      REQUIRE((joined_bits(a, b) & ~(kCountedBit << 1)) == ((a | b) & ~(kCountedBit << 1)));
      for (const std::uint32_t c : {0U, 8U, 16U, 24U, 255U}) {
        REQUIRE(joined_bits(joined_bits(a, b), c) == joined_bits(a, joined_bits(b, c)));
      }
    }
  }
  CHECK(joined_bits(kCountedBit, 0) == kCountedBit);
  CHECK(joined_bits(kCountedBit, kCountedBit) == (kCountedBit | kCountedBit << 1));
}

TEST_CASE("only layers between the first and the last matter") {
  ColumnTables tables{};
  tables.first_block_z = 4000;
  tables.last_block_z = 4010;
  tables.voxels_per_cell = 4;
  CHECK(cells_of(tables) == 4);
  CHECK(column_layer(tables, encode({17, 33, 3999})) == -1);
  CHECK(column_layer(tables, encode({17, 33, 4000})) == 0);
  CHECK(column_layer(tables, encode({8191, 8191, 4010})) == 10);
  CHECK(column_layer(tables, encode({17, 33, 4011})) == -1);
}
