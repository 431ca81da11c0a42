// SPDX-License-Identifier: Apache-2.0
// OctoMap files from hostile hands. The first byte picks the way in: the bytes as a file, as a tree behind a good
// header, or as patches of a good file. Whatever is accepted must come back the same from a file that we write of it.
#include <array>
#include <cstdlib>
#include <string>

#include "mapper/files/octomap_read.hpp"
#include "mapper/files/octomap_write.hpp"
#include "mapper/map_hash.hpp"

namespace {

using namespace g3d::mapper;

OctomapOptions small_memory() {
  OctomapOptions options;
  options.memory_limit_bytes = std::size_t{1} << 18;
  return options;
}

void check_file(ByteSpan file) {
  const auto read = decode_octomap(file, "fuzz.ot", small_memory());
  if (!read) return;
  const VoxelMap& map = *read.value().map;
  const auto again = decode_octomap(encode_octomap_full(map), "again.ot", small_memory());
  if (!again || map_hash(*again.value().map) != map_hash(map)) std::abort();
  const auto binary = decode_octomap(encode_octomap_binary(map), "again.bt", small_memory());
  if (!binary || binary.value().map->counts().occupied != map.counts().occupied ||
      binary.value().map->counts().free != map.counts().free) {
    std::abort();
  }
}

Bytes with_header(std::uint8_t kind, ByteSpan tree) {
  const bool is_binary = kind % 3 == 2;
  const std::string header = std::string(is_binary ? "# Octomap OcTree binary file\n" : "# Octomap OcTree file\n") +
                             (kind % 3 == 1 ? "id ColorOcTree" : "id OcTree") + "\nsize " + std::to_string(kind / 3) +
                             "\nres 0.05\ndata\n";
  Bytes file(header.begin(), header.end());
  put_bytes(file, tree);
  return file;
}

Bytes good_file(std::uint8_t kind) {
  VoxelMap map(g3d::mapper::Grid{0.05F}, {16, 16, 64});
  BlockValues values;
  for (BlockKey key = 0; key < 1U + kind % 4U; ++key) {
    values.fill(kUnknownRgbo);
    for (std::size_t i = key; i < values.size(); i += 1U + kind)
      values[i] = kind % 2 == 0 ? 30U : make_rgbo(9, 8, kind, 20);
    if (key == 2) values.fill(1);
    (void)map.write_block(key * kind, values);
  }
  return kind % 3 == 0 ? encode_octomap_binary(map) : encode_octomap_full(map);
}

void patch(Bytes& file, ByteSpan patches) {
  for (std::size_t i = 0; i + 3 <= patches.size(); i += 3) {
    file[(patches[i] | std::size_t{patches[i + 1]} << 8) % file.size()] ^= patches[i + 2];
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes < 2) return 0;
  const ByteSpan rest(data + 2, size_bytes - 2);
  switch (data[0] % 3) {
    case 0:
      check_file(rest);
      break;
    case 1:
      check_file(with_header(data[1], rest));
      break;
    default: {
      static std::array<Bytes, 256> good;
      if (good[data[1]].empty()) good[data[1]] = good_file(data[1]);
      Bytes file = good[data[1]];
      patch(file, rest);
      check_file(file);
    }
  }
  return 0;
}
