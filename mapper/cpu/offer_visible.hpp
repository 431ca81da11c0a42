// SPDX-License-Identifier: Apache-2.0
// From visible blocks to the updater: what the ways of finding free space that look at voxels, and not along rays, have
// in common.
#pragma once

#include "mapper/cpu/free_space.hpp"
#include "mapper/cpu/visible_blocks.hpp"

namespace g3d::mapper::cpu {

/// Begins the updater and offers it every visible block that this frame may change, with its hits. `look(block, levels,
/// hits, flags)` fills in the flags of a block that has to be looked at; false if none of its voxels is free. `levels`
/// is nullptr if the block is not dense, `hits` if it has none. `is_strong(block, place)`: is that voxel free by
/// measured rays alone?
template <typename Look, typename IsStrong>
void offer_visible(const FrameWork& work, const VisibleBlocks& visible, Look&& look, IsStrong&& is_strong) {
  const std::uint32_t chunks = visible.chunk_count();
  work.updater.begin(work.frame, work.with_colour, work.kernels, work.frame_number, chunks + 1,
                     visible.blocks_per_chunk(), work.pool.threads() == 1);
  work.pool.parallel_for(chunks, [&](std::uint32_t chunk) {
    BlockKey key = 0;
    std::uint32_t slot = kNoSlot;
    HitRecord* hits = nullptr;
    const auto wants = [&](int bx, int by, int bz) {
      key = work.frame.block_key(bx, by, bz);
      slot = work.updater.remembered_slot(key);
      hits = work.hits.find(work.frame.block_id(bx, by, bz));
      return hits != nullptr || !work.updater.is_settled(slot);
    };
    const auto soon = [&](int bx, int by, int bz) {
      work.updater.prefetch_header(work.frame.block_key(bx, by, bz));
      work.hits.prefetch(work.frame.block_id(bx, by, bz));
    };
    visible.for_chunk(chunk, soon, wants, [&](const BlockView& block, BlockClass found) {
      work.updater.prefetch(key, slot, hits);
      const auto strong = [&](int place) { return is_strong(block, place); };
      if (found == BlockClass::all_free) {
        work.updater.offer_all_free(chunk, key, hits, strong);
        return;
      }
      alignas(64) FreeFlags flags;
      if (look(block, work.updater.levels_of(slot), hits, flags)) {
        work.updater.offer_some_free(chunk, key, flags, hits, strong);
      } else if (hits != nullptr) {
        work.updater.offer_hits(chunk, key, *hits);
      }
    });
  });
}

}  // namespace g3d::mapper::cpu
