// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/hit_scatter.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace g3d::mapper::cpu {
namespace {

constexpr int kHitRowsPerChunk = 16;

template <std::size_t... I>
std::array<ReservedArray<std::uint32_t>, sizeof...(I)> reserve_each(std::size_t count, std::index_sequence<I...>) {
  return {((void)I, ReservedArray<std::uint32_t>(count))...};
}

}  // namespace

HitScatter::HitScatter(const SensorGeometry& sensor)
    : sensor_(&sensor),
      chunks_((sensor.camera.height_px + kHitRowsPerChunk - 1) / kHitRowsPerChunk),
      runs_per_list_(static_cast<std::size_t>(kHitRowsPerChunk) * static_cast<std::size_t>(sensor.camera.width_px)),
      runs_(static_cast<std::size_t>(chunks_) * kShards * runs_per_list_),
      run_counts_(static_cast<std::size_t>(chunks_) * kShards, 0),
      record_of_block_(sensor.max_box_blocks()),
      records_(std::min(sensor.camera.pixel_count(), sensor.max_box_blocks())),
      shard_records_(reserve_each(records_.size(), std::make_index_sequence<kShards>{})) {
  // The lists of runs lie far apart, and every frame writes a little into each.
  constexpr std::size_t kFirstPart_bytes = std::size_t{8} << 20;
  runs_.touch(runs_.size_bytes());
  record_of_block_.touch(kFirstPart_bytes);
  records_.touch(kFirstPart_bytes);
  for (auto& list : shard_records_) list.touch(kFirstPart_bytes / kShards);
}

void HitScatter::clear() {
  const std::uint32_t count = record_count_.load(std::memory_order_relaxed);
  for (std::uint32_t i = 0; i < count; ++i) record_of_block_[records_[i].block_id] = 0;
  record_count_.store(0, std::memory_order_relaxed);
  shard_counts_.fill(0);
}

void HitScatter::compute(const FrameGeometry& frame, const RayEnds& ends, const std::uint8_t* rgb,
                         const Kernels& kernels, ThreadPool& pool) {
  if (pool.threads() == 1) {
    // The same order within each shard as below, without the way through the lists.
    for (int chunk = 0; chunk < chunks_; ++chunk) {
      cut_rows(chunk, frame, ends, rgb, kernels, [&](const Run& run) { put(run, record_for(run.block_id)); });
    }
    for (int shard = 0; ends.counts().too_near > 0 && shard < kShards; ++shard) find_held_only(shard);
    return;
  }
  pool.parallel_for(static_cast<std::uint32_t>(chunks_),
                    [&](std::uint32_t chunk) { collect(static_cast<int>(chunk), frame, ends, rgb, kernels); });
  pool.parallel_for(kShards, [&](std::uint32_t shard) {
    scatter_shard(static_cast<int>(shard));
    if (ends.counts().too_near > 0) find_held_only(static_cast<int>(shard));
  });
}

// Runs begin where `starts` says so, 64 pixels to a word of bits. Where the row above was in the same voxel there is
// nothing to add: its pixels have lower indices, and its hit and colour are recorded.
template <typename Emit>
void HitScatter::cut_rows(int chunk, const FrameGeometry& frame, const RayEnds& ends, const std::uint8_t* rgb,
                          const Kernels& kernels, Emit&& emit) {
  const int width = sensor_->camera.width_px;
  const int first = chunk * kHitRowsPerChunk;
  const int last = std::min(first + kHitRowsPerChunk, sensor_->camera.height_px);
  const auto& R = frame.rotation;
  std::array<std::uint8_t, hal::kMaxImageSide_px + 64> starts;
  std::fill(starts.begin() + width, starts.begin() + width + 64, std::uint8_t{0});  // nothing begins beyond the row
  alignas(64) std::array<std::uint32_t, hal::kMaxImageSide_px> block_ids;
  alignas(64) std::array<std::uint16_t, hal::kMaxImageSide_px> places;
  alignas(64) std::array<std::array<std::uint32_t, hal::kMaxImageSide_px>, 2> codes;  // of this row and the one above
  const bool codes_are_exact = frame.block_count() < kMostCodedBlocks;
  UnprojectRow row{};
  row.column_slope = sensor_->column_slope.data();
  row.width = width;
  row.near_raw = sensor_->near_raw;
  row.far_raw = sensor_->far_raw;
  row.metres_per_unit = sensor_->metres_per_unit;
  row.resolution_m = sensor_->resolution_m;
  row.origin[0] = frame.origin.x;
  row.origin[1] = frame.origin.y;
  row.origin[2] = frame.origin.z;
  row.nx_blocks = frame.nx_blocks;
  row.nxy_blocks = frame.nx_blocks * frame.ny_blocks;
  row.block_id = block_ids.data();
  row.place = places.data();
  row.starts = starts.data();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    row.column[axis] = R[3 * axis];
    row.translation[axis] = frame.translation_m[axis];
  }
  for (int v = first; v < last; ++v) {
    const float slope = sensor_->row_slope[static_cast<std::size_t>(v)];
    for (std::size_t axis = 0; axis < 3; ++axis) row.row_part[axis] = R[3 * axis + 1] * slope + R[3 * axis + 2];
    const std::size_t offset = static_cast<std::size_t>(v) * static_cast<std::size_t>(width);
    row.depth = ends.depth() + offset;
    row.colour_flag = ends.colour_flags() + offset;
    const auto own = static_cast<std::size_t>(v & 1);
    row.code = codes[own].data();
    kernels.unproject_row(row);
    if (v > first && codes_are_exact) kernels.drop_repeats(row.code, codes[own ^ 1].data(), width, starts.data());
    const std::uint8_t* colours = rgb != nullptr ? rgb + 3 * offset : nullptr;
    for (int u = 0; u < width; u += 64) {
      std::uint64_t bits = 0;
      for (int byte = 0; byte < 8; ++byte) {
        std::uint64_t eight;
        std::memcpy(&eight, starts.data() + u + 8 * byte, sizeof eight);
        // Eight bytes of 0 or 1 become eight bits: byte i is moved to bit 56 + i by one of the factor's bits.
        bits |= ((eight * 0x0102040810204080ULL) >> 56) << (8 * byte);
      }
      for (; bits != 0; bits &= bits - 1) {
        const int begin = u + std::countr_zero(bits);
        const bool too_near = row.depth[begin] < row.near_raw;
        std::uint32_t rgb_flags = static_cast<std::uint32_t>(too_near ? kHeldFlag : kHitFlag) << 24;
        if (colours != nullptr) {
          const std::uint8_t* colour = colours + 3 * begin;
          rgb_flags |= static_cast<std::uint32_t>(too_near ? 0 : row.colour_flag[begin]) << 24 |
                       static_cast<std::uint32_t>(colour[0]) | static_cast<std::uint32_t>(colour[1]) << 8 |
                       static_cast<std::uint32_t>(colour[2]) << 16;
        }
        emit(Run{block_ids[static_cast<std::size_t>(begin)], rgb_flags, places[static_cast<std::size_t>(begin)]});
      }
    }
  }
}

void HitScatter::collect(int chunk, const FrameGeometry& frame, const RayEnds& ends, const std::uint8_t* rgb,
                         const Kernels& kernels) {
  const std::size_t list = static_cast<std::size_t>(chunk) * kShards;
  std::array<Run*, kShards> next;
  for (std::size_t s = 0; s < kShards; ++s) next[s] = &runs_[(list + s) * runs_per_list_];
  const auto lists = next;
  cut_rows(chunk, frame, ends, rgb, kernels, [&](const Run& run) { *next[run.block_id % kShards]++ = run; });
  for (std::size_t s = 0; s < kShards; ++s) run_counts_[list + s] = static_cast<std::uint32_t>(next[s] - lists[s]);
}

HitRecord& HitScatter::record_for(std::uint32_t block_id) {
  std::uint32_t& index = record_of_block_[block_id];
  if (index == 0) [[unlikely]] {
    index = record_count_.fetch_add(1, std::memory_order_relaxed) + 1;
    HitRecord& fresh = records_[index - 1];
    fresh.block_id = block_id;
    fresh.consumed = 0;
    fresh.held_only = 0;
    fresh.flags.fill(0);
    const std::size_t shard = block_id % kShards;
    shard_records_[shard][shard_counts_[shard]++] = index - 1;
  }
  return records_[index - 1];
}

void HitScatter::find_held_only(int s) {
  for (const std::uint32_t index : shard(s)) {
    std::uint8_t any = 0;
    for (const std::uint8_t flags : records_[index].flags) any |= flags;
    records_[index].held_only = (any & kHitFlag) != 0 ? 0 : 1;
  }
}

void HitScatter::scatter_shard(int shard) {
  for (int chunk = 0; chunk < chunks_; ++chunk) {
    const std::size_t which = static_cast<std::size_t>(chunk) * kShards + static_cast<std::size_t>(shard);
    const Run* run = &runs_[which * runs_per_list_];
    for (const Run* end = run + run_counts_[which]; run != end; ++run) {
      put(*run, record_for(run->block_id));
    }
  }
}

}  // namespace g3d::mapper::cpu
