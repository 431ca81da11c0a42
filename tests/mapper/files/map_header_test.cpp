// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/map_header.hpp"

#include <catch2/catch.hpp>
#include <limits>

using namespace g3d;
using namespace g3d::mapper;

namespace {

MapInfo sample() {
  MapInfo info;
  info.grid.resolution_m = 0.02F;
  info.meta = {hal::from_xyz_rpy(1, 2, 3, 0.1, 0.2, 0.3), {5, 2}, 0x1122334455667788ULL};
  info.counts = {1000, 5000, 900, 20, 8};
  info.dense_blocks = 12;
  info.colour_bricks = 30;
  info.chunks = 1;
  return info;
}

hal::Result<MapInfo> reread(const MapInfo& info) { return decode_header(encode_header(info), "h.g3d"); }

}  // namespace

TEST_CASE("A header comes back") {
  const auto read = reread(sample());
  REQUIRE(read.ok());
  CHECK(read.value().grid.resolution_m == 0.02F);
  CHECK(read.value().meta.layer_id == 0x1122334455667788ULL);
  CHECK(read.value().meta.T_world_map.rotation_xyzw == sample().meta.T_world_map.rotation_xyzw);
  CHECK(read.value().counts.coloured == 900);
  CHECK(read.value().colour_bricks == 30);
  CHECK(encode_header(sample()).size() == kMapHeaderBytes);
}

TEST_CASE("Numbers that cannot be are refused even under a good CRC") {
  const auto refused = [](auto change) {
    MapInfo info = sample();
    change(info);
    const auto read = reread(info);
    return !read.ok() && read.error().reason == hal::Reason::out_of_range &&
           read.error().text.find("h.g3d: byte ") == 0;
  };
  CHECK_FALSE(refused([](MapInfo&) {}));
  CHECK(refused([](MapInfo& i) { i.grid.resolution_m = 0; }));
  CHECK(refused([](MapInfo& i) { i.grid.resolution_m = std::numeric_limits<float>::quiet_NaN(); }));
  CHECK(refused([](MapInfo& i) { i.meta.steps.hit = 0; }));
  CHECK(refused([](MapInfo& i) { i.meta.steps.miss = 17; }));
  CHECK(refused([](MapInfo& i) { i.meta.T_world_map.translation_m[1] = std::numeric_limits<double>::infinity(); }));
  CHECK(refused([](MapInfo& i) { i.counts.blocks = 5000; }));  // more than one chunk holds
  CHECK(refused([](MapInfo& i) { i.dense_blocks = 13; }));
  CHECK(refused([](MapInfo& i) { i.colour_bricks = 97; }));
  CHECK(refused([](MapInfo& i) { i.counts.free = 20 * 512; }));
  CHECK(refused([](MapInfo& i) { i.counts.coloured = 1001; }));
}

TEST_CASE("A chunk header is read at its place and checked against its payload") {
  const Bytes payload{1, 2, 3, 4, 5};
  std::uint32_t crc = 0;
  Bytes file(10, 0);
  put_bytes(file, encode_chunk_header({10, 3, 9, 2}, payload, crc));
  put_bytes(file, payload);
  const auto chunk = decode_chunk_header(file, 10, "c.g3d");
  REQUIRE(chunk.ok());
  CHECK(chunk.value().entry == ChunkEntry{10, 3, 9, 2});
  CHECK(chunk.value().crc == crc);
  CHECK(chunk.value().payload.size() == 5);
  CHECK(chunk.value().end_offset == file.size());
  CHECK(decode_chunk_header(file, 9, "c.g3d").error().reason == hal::Reason::malformed);
  CHECK(decode_chunk_header(file, 1000, "c.g3d").error().reason == hal::Reason::truncated);
  file.back() ^= 1;
  CHECK(decode_chunk_header(file, 10, "c.g3d").error().reason == hal::Reason::bad_checksum);
}

TEST_CASE("The index is compared with what was read") {
  const std::vector<ChunkEntry> chunks{{148, 1, 5, 3}, {900, 7, 9, 2}};
  const Bytes index = encode_index(chunks, 0, 77);
  CHECK(index.size() == 8 + 2 * kIndexEntryBytes + 4 + kMapEndBytes);
  CHECK(check_index(index, 0, chunks, 77, "i.g3d").ok());
  CHECK_FALSE(check_index(index, 0, chunks, 78, "i.g3d").ok());
  CHECK_FALSE(check_index(index, 0, {chunks[0]}, 77, "i.g3d").ok());
}

TEST_CASE("The CRC is zlib's") {
  const std::string text = "123456789";
  CHECK(crc32_of(ByteSpan(reinterpret_cast<const std::uint8_t*>(text.data()), text.size())) == 0xCBF43926U);
}
