// SPDX-License-Identifier: Apache-2.0
#include "tests/support/changed_blocks.hpp"

#include <set>

#include "mapper/files/map_file.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/sample_maps.hpp"

namespace g3d::test {

using mapper::BlockValues;

std::vector<BlockValues> changed_blocks(const Workload& work, float resolution_m, std::size_t frames_per_update,
                                        std::uint32_t per_update) {
  mapper::MapperConfig config;
  config.resolution_m = resolution_m;
  config.capacity = mapper::capacity_for_bytes(std::size_t{1536} << 20);
  mapper::Mapper mapper(config, work.camera);
  std::vector<BlockValues> blocks;
  std::set<std::uint32_t> changed;
  tests::Random random(5);
  std::size_t frames = 0;
  for (const PosedImage& image : work.frames) {
    (void)mapper.integrate(image.frame, image.T_world_camera);
    for (const std::uint32_t slot : mapper.changed_slots()) changed.insert(slot);
    if (++frames % frames_per_update != 0 && frames != work.frames.size()) continue;
    for (const std::uint32_t slot : changed) {
      if (random.below(static_cast<std::uint32_t>(changed.size())) >= per_update) continue;
      const mapper::BlockKey key = mapper.map().header(slot).key;
      if (key != mapper::VoxelMap::kNoKey) mapper.map().read_stored_block(key, blocks.emplace_back());
    }
    changed.clear();
  }
  return blocks;
}

std::vector<BlockValues> changed_blocks(const std::string& earlier, const std::string& later) {
  const auto before = mapper::load_map(earlier);
  const auto after = mapper::load_map(later);
  std::vector<BlockValues> blocks;
  if (!before || !after) return blocks;
  BlockValues was;
  BlockValues is;
  for (const mapper::BlockKey key : after.value().map->sorted_keys()) {
    before.value().map->read_stored_block(key, was);
    after.value().map->read_stored_block(key, is);
    if (was != is) blocks.push_back(is);
  }
  return blocks;
}

std::vector<BlockValues> all_blocks(const std::string& path) {
  const auto loaded = mapper::load_map(path);
  std::vector<BlockValues> blocks;
  if (!loaded) return blocks;
  for (const mapper::BlockKey key : loaded.value().map->sorted_keys()) {
    loaded.value().map->read_stored_block(key, blocks.emplace_back());
  }
  return blocks;
}

}  // namespace g3d::test
