// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/map_stream.hpp"

#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

Bytes saved(const VoxelMap& map, const MapFileMeta& meta = {}, SaveReport* report = nullptr) {
  Bytes bytes;
  const auto done = encode_map(map, meta, [&](ByteSpan part) {
    put_bytes(bytes, part);
    return hal::Result<void>{};
  });
  REQUIRE(done.ok());
  if (report != nullptr) *report = done.value();
  return bytes;
}

}  // namespace

TEST_CASE("A map comes back from its file bit by bit") {
  const int blocks = GENERATE(0, 1, 2, 600, 9000);
  const auto map = tests::random_map(static_cast<std::uint64_t>(blocks) + 1, blocks);
  MapFileMeta meta{hal::from_xyz_rpy(1, -2, 3, 0.1, 0.2, 0.3), {5, 3}, 77};
  SaveReport report;
  const Bytes bytes = saved(*map, meta, &report);
  CHECK(report.file_bytes == bytes.size());
  CHECK(report.counts.occupied == map->counts().occupied);

  const auto loaded = decode_map(bytes, "memory");
  REQUIRE(loaded.ok());
  CHECK(tests::same_map(*map, *loaded.value().map));
  CHECK(map_hash(*map) == map_hash(*loaded.value().map));
  const MapInfo& info = loaded.value().info;
  CHECK(info.grid == map->grid());
  CHECK(info.meta.steps == meta.steps);
  CHECK(info.meta.layer_id == 77);
  CHECK(info.meta.T_world_map.translation_m == meta.T_world_map.translation_m);
  CHECK(info.meta.T_world_map.rotation_xyzw == meta.T_world_map.rotation_xyzw);
  CHECK(info.file_bytes == bytes.size());
  CHECK(info.counts.blocks == map->sorted_keys().size());
  CHECK(saved(*loaded.value().map, meta) == bytes);  // the same map gives the same file
}

TEST_CASE("Blocks without any known voxel are left out of the file") {
  VoxelMap map(Grid{0.05F}, {16, 16, 16});
  map.find_or_insert(5);
  map.find_or_insert(9);
  BlockValues values;
  values.fill(0);
  REQUIRE(map.write_block(7, values));
  const auto loaded = decode_map(saved(map), "memory");
  REQUIRE(loaded.ok());
  CHECK(loaded.value().map->block_count() == 1);
  CHECK(loaded.value().map->at(7ULL << kBlockShift) == 0);
}

TEST_CASE("A damaged map file is refused, wherever the damage is") {
  const auto map = tests::random_map(3, 300);
  const Bytes good = saved(*map);
  tests::Random random(11);
  for (int i = 0; i < 400; ++i) {
    Bytes bad = good;
    const std::size_t at = i < 160 ? static_cast<std::size_t>(i) : random.below(static_cast<std::uint32_t>(bad.size()));
    bad[at] ^= static_cast<std::uint8_t>(1U << random.below(8));
    const auto loaded = decode_map(bad, "spoiled.g3d");
    REQUIRE_FALSE(loaded.ok());
    REQUIRE(loaded.error().text.find("spoiled.g3d") == 0);
  }
}

TEST_CASE("A map file cut off or prolonged anywhere is refused") {
  const Bytes good = saved(*tests::random_map(4, 100));
  for (std::size_t size = 0; size < good.size(); size += size < 200 ? 1 : 97) {
    const auto loaded = decode_map(ByteSpan(good).first(size), "cut.g3d");
    REQUIRE_FALSE(loaded.ok());
  }
  Bytes longer = good;
  longer.push_back(0);
  const auto loaded = decode_map(longer, "long.g3d");
  REQUIRE_FALSE(loaded.ok());
  CHECK(loaded.error().text.find("bytes follow the end") != std::string::npos);
}

TEST_CASE("A header that asks for too much memory is refused before any is taken") {
  const auto map = tests::random_map(5, 400);
  const Bytes bytes = saved(*map);
  LoadOptions options;
  options.memory_limit_bytes = 10000;
  const auto loaded = decode_map(bytes, "big.g3d", options);
  REQUIRE_FALSE(loaded.ok());
  CHECK(loaded.error().reason == hal::Reason::no_capacity);

  options.memory_limit_bytes = std::size_t{1} << 30;
  options.capacity = MapCapacity{20, 20, 20};
  const auto too_small = decode_map(bytes, "big.g3d", options);
  REQUIRE_FALSE(too_small.ok());
  CHECK(too_small.error().reason == hal::Reason::no_capacity);
}

TEST_CASE("Another program's file and a newer version are told apart") {
  const auto other = decode_map(Bytes(1000, 0x55), "other.bin");
  REQUIRE_FALSE(other.ok());
  CHECK(other.error().text.find("not a g3d map") != std::string::npos);
  Bytes newer = saved(*tests::random_map(6, 10));
  newer[8] = 2;
  const auto loaded = decode_map(newer, "newer.g3d");
  REQUIRE_FALSE(loaded.ok());
  CHECK(loaded.error().reason == hal::Reason::unsupported);
}

TEST_CASE("A sink that fails stops the saving and its error comes through") {
  const auto map = tests::random_map(8, 9000);
  int calls = 0;
  const auto done = encode_map(*map, {}, [&](ByteSpan) -> hal::Result<void> {
    if (++calls == 3) return hal::Error{hal::Reason::disk_full, "no space"};
    return {};
  });
  REQUIRE_FALSE(done.ok());
  CHECK(done.error().reason == hal::Reason::disk_full);
  CHECK(calls == 3);
}
