// SPDX-License-Identifier: Apache-2.0
// Every trusted reading goes to the voxel that it falls into: exact, whatever the integrator. One that is too near to
// be trusted goes there as well, and says only that no ray of the same frame may free the voxel. The image is cut into
// runs of pixels that stay in one voxel; runs are dealt to shards by their block, and each shard walks its runs in
// pixel order, so that the lowest pixel index colours a voxel whatever the number of threads. A single thread needs no
// shards.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cpu/kernels/kernels.hpp"
#include "mapper/cpu/ray_ends.hpp"
#include "mapper/cpu/thread_pool.hpp"
#include "mapper/pool.hpp"

namespace g3d::mapper::cpu {

/// What one frame measured in one block.
struct HitRecord {
  std::uint32_t block_id;                           ///< in the frame's box
  std::uint16_t consumed;                           ///< set by the integrator when it has applied the record
  std::uint16_t held_only;                          ///< 1: no voxel was hit, some are held
  alignas(64) std::array<std::uint8_t, 512> flags;  ///< kHitFlag, kColourFlag, kHeldFlag by place
  std::array<std::uint32_t, 512> rgb;               ///< R | G << 8 | B << 16 of the lowest pixel index that may colour
                                                    ///< the voxel; valid where kColourFlag is set
};

class HitScatter {
 public:
  static constexpr int kShards = 8;

  explicit HitScatter(const SensorGeometry& sensor);

  /// `rgb`: colour image, or nullptr.
  void compute(const FrameGeometry& frame, const RayEnds& ends, const std::uint8_t* rgb, const Kernels& kernels,
               ThreadPool& pool);
  /// Forgets the records of the last frame; must precede the next compute().
  void clear();

  /// Record of a block of the frame's box, nullptr if nothing was measured in it.
  [[nodiscard]] HitRecord* find(std::uint32_t block_id) {
    const std::uint32_t index = record_of_block_[block_id];
    return index == 0 ? nullptr : &records_[index - 1];
  }
  void prefetch(std::uint32_t block_id) const { __builtin_prefetch(&record_of_block_[block_id]); }
  /// Records of one shard in a fixed order.
  [[nodiscard]] std::span<const std::uint32_t> shard(int s) const {
    return {shard_records_[static_cast<std::size_t>(s)].data(), shard_counts_[static_cast<std::size_t>(s)]};
  }
  /// Blocks in which something was measured.
  [[nodiscard]] std::uint32_t block_count() const { return record_count_.load(std::memory_order_relaxed); }
  [[nodiscard]] HitRecord& record(std::uint32_t index) { return records_[index]; }

 private:
  /// Consecutive pixels of a row that fall into one voxel and all may, or all may not, give their colour. It is
  /// fetched here, while the row is at hand.
  struct Run {
    std::uint32_t block_id;
    std::uint32_t rgb_flags;  ///< colour of the first pixel, flags in the highest byte
    std::uint32_t place;
  };
  static void put(const Run& run, HitRecord& record) {
    // Where no colour is known yet the run's is a proposal that counts only once the flag says so.
    const std::uint8_t old_flags = record.flags[run.place];
    std::uint32_t& colour = record.rgb[run.place];
    // By arithmetic: whether a voxel was hit before cannot be guessed, and a branch on it costs more than all the rest.
    const std::uint32_t keep = 0U - static_cast<std::uint32_t>((old_flags & kColourFlag) / kColourFlag);
    colour = (colour & keep) | (run.rgb_flags & ~keep);
    record.flags[run.place] = static_cast<std::uint8_t>(old_flags | (run.rgb_flags >> 24));
  }
  /// emit(Run) for every run of a chunk of rows that holds readings, in pixel order.
  template <typename Emit>
  void cut_rows(int chunk, const FrameGeometry& frame, const RayEnds& ends, const std::uint8_t* rgb,
                const Kernels& kernels, Emit&& emit);
  void collect(int chunk, const FrameGeometry& frame, const RayEnds& ends, const std::uint8_t* rgb,
               const Kernels& kernels);
  void scatter_shard(int shard);
  void find_held_only(int shard);
  [[nodiscard]] HitRecord& record_for(std::uint32_t block_id);

  const SensorGeometry* sensor_;
  int chunks_;
  std::size_t runs_per_list_;
  ReservedArray<Run> runs_;                       ///< [chunk][shard][runs_per_list_]
  std::vector<std::uint32_t> run_counts_;         ///< [chunk][shard]
  ReservedArray<std::uint32_t> record_of_block_;  ///< index + 1; 0 = none
  ReservedArray<HitRecord> records_;
  std::atomic<std::uint32_t> record_count_{0};
  std::array<ReservedArray<std::uint32_t>, kShards> shard_records_;
  std::array<std::uint32_t, kShards> shard_counts_{};
};

}  // namespace g3d::mapper::cpu
