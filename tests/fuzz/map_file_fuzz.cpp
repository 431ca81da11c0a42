// SPDX-License-Identifier: Apache-2.0
// `map.g3d` from hostile hands. The first byte picks the way in, because CRCs and zstd frames stop blind mutation
// early: the bytes as a file; a good file with patches; the same with its CRCs made right again; raw streams, packed
// properly. Whatever is accepted must come back the same from a second round.
#include <zstd.h>

#include <array>
#include <cstdlib>

#include "mapper/files/map_stream.hpp"
#include "mapper/map_hash.hpp"

namespace {

using namespace g3d;
using namespace g3d::mapper;

constexpr std::size_t kStreams = 21;  // of block_codec.cpp
constexpr std::size_t kMaxRawBytes = 4096;

Bytes encoded(const VoxelMap& map) {
  Bytes bytes;
  const auto done = encode_map(
      map, {},
      [&](ByteSpan part) {
        put_bytes(bytes, part);
        return hal::Result<void>{};
      },
      1);
  if (!done) std::abort();
  return bytes;
}

Bytes good_file(std::uint8_t kind) {
  VoxelMap map(Grid{0.05F}, {64, 64, 64});
  BlockValues values;
  for (BlockKey key = 0; key < 3U + kind % 5U; ++key) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto level = static_cast<std::uint8_t>((i * (kind + 1U) / 64 + key) % 33);
      values[i] =
          level > kUnknownLevel ? make_rgbo(kind, static_cast<std::uint8_t>(i), 7, level | kHasColourBit) : level;
    }
    if (key % 2 == kind % 2) values.fill(kind % 33U);
    (void)map.write_block(key * key * (kind + 1U), values);
  }
  return encoded(map);
}

/// Triples: two bytes of place, one byte to xor.
void patch(Bytes& file, ByteSpan patches) {
  for (std::size_t i = 0; i + 3 <= patches.size(); i += 3) {
    const std::size_t place = (patches[i] | std::size_t{patches[i + 1]} << 8) % file.size();
    file[place] ^= patches[i + 2];
  }
}

void put_crc(Bytes& file, std::size_t at, std::uint32_t crc) { std::memcpy(file.data() + at, &crc, 4); }

void repair(Bytes& file) {
  if (file.size() < kMapHeaderBytes + kChunkHeaderBytes) return;
  put_crc(file, kMapHeaderBytes - 4, crc32_of(ByteSpan(file).first(kMapHeaderBytes - 4)));
  const std::size_t chunk = kMapHeaderBytes;
  std::uint32_t payload_bytes = 0;
  std::memcpy(&payload_bytes, file.data() + chunk + 24, 4);
  if (payload_bytes > file.size() - chunk - kChunkHeaderBytes) return;
  const ByteSpan all(file);
  put_crc(file, chunk + 28,
          crc32_of(all.subspan(chunk + kChunkHeaderBytes, payload_bytes), crc32_of(all.subspan(chunk, 28))));
}

Bytes packed_streams(ByteSpan data) {
  Bytes payload(kStreams * 8);
  ByteReader in(data);
  for (std::size_t id = 0; id < kStreams; ++id) {
    std::uint16_t wanted = 0;
    ByteSpan raw;
    if (!in.take(wanted)) break;
    if (!in.take_bytes(wanted % kMaxRawBytes % (in.left() + 1), raw)) break;
    const std::size_t at = payload.size();
    payload.resize(at + ZSTD_compressBound(raw.size()));
    const std::size_t packed = ZSTD_compress(payload.data() + at, payload.size() - at, raw.data(), raw.size(), 1);
    payload.resize(at + packed);
    const std::array<std::uint32_t, 2> sizes{static_cast<std::uint32_t>(raw.size()),
                                             static_cast<std::uint32_t>(packed)};
    std::memcpy(payload.data() + id * 8, sizes.data(), 8);
  }
  return payload;
}

void check_file(ByteSpan file) {
  LoadOptions options;
  options.memory_limit_bytes = std::size_t{1} << 21;
  const auto loaded = decode_map(file, "fuzz.g3d", options);
  if (!loaded) return;
  const auto again = decode_map(encoded(*loaded.value().map), "again.g3d", options);
  if (!again || map_hash(*again.value().map) != map_hash(*loaded.value().map)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes < 2) return 0;
  const ByteSpan rest(data + 2, size_bytes - 2);
  static BlockDecoder decoder;
  switch (data[0] % 4) {
    case 0:
      check_file(rest);
      break;
    case 3:
      (void)decoder.decode(packed_streams(rest)).ok();
      break;
    default: {
      static std::array<Bytes, 256> good;
      if (good[data[1]].empty()) good[data[1]] = good_file(data[1]);
      Bytes file = good[data[1]];
      patch(file, rest);
      if (data[0] % 4 == 2) repair(file);
      check_file(file);
    }
  }
  return 0;
}
