// SPDX-License-Identifier: Apache-2.0
#include "mapper/map_hash.hpp"

#include <sodium.h>

#include <array>

namespace g3d::mapper {
namespace {

void put_u32(std::uint8_t* out, std::uint32_t v) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(v >> (8 * i));
}

}  // namespace

std::string map_hash(const VoxelMap& map) { return map_hash(MemoryBlocks(map)); }

std::string map_hash(const BlockSource& source) {
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, 32);
  std::array<std::uint8_t, 8 + 4 * kBlockVoxels> bytes;
  (void)source.visit_regions([&](std::span<const StoredBlock> blocks) {
    for (const StoredBlock& block : blocks) {
      put_u32(bytes.data(), static_cast<std::uint32_t>(block.key));
      put_u32(bytes.data() + 4, static_cast<std::uint32_t>(block.key >> 32));
      for (std::size_t i = 0; i < block.values.size(); ++i)
        put_u32(bytes.data() + 8 + 4 * i, published(block.values[i]));
      crypto_generichash_update(&state, bytes.data(), bytes.size());
    }
    return hal::Result<void>{};
  });
  std::array<std::uint8_t, 32> digest;
  crypto_generichash_final(&state, digest.data(), digest.size());
  std::array<char, 65> hex;
  sodium_bin2hex(hex.data(), hex.size(), digest.data(), digest.size());
  return {hex.data(), 64};
}

}  // namespace g3d::mapper
