// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/bulk_rays.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

namespace g3d::mapper::cpu {
namespace {

constexpr std::size_t kRaysPerChunk = 512;
constexpr std::uint32_t kWordsPerChunk = 1U << 14;

struct HostBlocks {
  const VoxelMap& map;
  [[nodiscard]] BlockLevels find(BlockKey key) const {
    const std::uint32_t slot = map.find(key);
    if (slot == kNoSlot) return {nullptr, kUnknownLevel};
    const BlockHeader& header = map.header(slot);
    if (header.plane == kNoSlot) return {nullptr, header.uniform_level};
    return {map.plane(header.plane).data(), 0};
  }
};

}  // namespace

void cast_bulk_rays(const VoxelMap& map, std::span<const BulkRay> rays, std::span<BulkHit> hits, ThreadPool& pool) {
  const std::size_t chunks = (rays.size() + kRaysPerChunk - 1) / kRaysPerChunk;
  pool.parallel_for(static_cast<std::uint32_t>(chunks), [&](std::uint32_t chunk) {
    const std::size_t end = std::min(rays.size(), (chunk + std::size_t{1}) * kRaysPerChunk);
    for (std::size_t i = chunk * kRaysPerChunk; i < end; ++i) {
      hits[i] = cast_bulk_ray(rays[i], map.grid().resolution_m, HostBlocks{map});
    }
  });
}

Look look_from(const SensorGeometry& sensor, const hal::RigidTransform& T_world_camera) {
  Look look{};
  const auto frame = frame_geometry(sensor, T_world_camera);
  if (!frame) return look;
  std::copy(frame->rotation.begin(), frame->rotation.end(), look.rotation);
  std::copy(frame->translation_m.begin(), frame->translation_m.end(), look.position_m);
  const VoxelIndex& o = frame->origin;
  const std::int32_t first[3] = {o.x / kBlockSide_cells, o.y / kBlockSide_cells, o.z / kBlockSide_cells};
  const std::int32_t blocks[3] = {frame->nx_blocks, frame->ny_blocks, frame->nz_blocks};
  std::copy_n(first, 3, look.first);
  std::copy_n(blocks, 3, look.blocks);
  return look;
}

std::size_t rays_from(const SensorGeometry& sensor, const hal::RigidTransform& T_world_camera, int stride_px,
                      std::span<BulkRay> rays) {
  const LookModel model = look_model(sensor, stride_px);
  const auto& R = T_world_camera.rotation;
  const auto& t = T_world_camera.translation_m;
  std::size_t count = 0;
  for (int v = 0; v < model.height_px; v += model.stride_px) {
    for (int u = 0; u < model.width_px && count < rays.size(); u += model.stride_px) {
      const float x = sensor.column_slope[static_cast<std::size_t>(u)];
      const float y = sensor.row_slope[static_cast<std::size_t>(v)];
      BulkRay& ray = rays[count++];
      ray = {};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ray.origin_m[axis] = t[axis];
        ray.direction[axis] = R[3 * axis] * x + R[3 * axis + 1] * y + R[3 * axis + 2];
      }
      ray.max_range_m = model.far_m * std::sqrt(x * x + y * y + 1.0F);
    }
  }
  return count;
}

LookModel look_model(const SensorGeometry& sensor, int stride_px) {
  return {sensor.resolution_m,
          static_cast<float>(sensor.near_raw) * sensor.metres_per_unit,
          static_cast<float>(sensor.far_raw) * sensor.metres_per_unit,
          sensor.camera.width_px,
          sensor.camera.height_px,
          std::max(stride_px, 1)};
}

LookCounter::LookCounter(const SensorGeometry& sensor) : sensor_(sensor), seen_(sensor.max_box_blocks() * kSeenWords) {}

void LookCounter::count(const VoxelMap& map, const LookModel& model, std::span<Look> looks, ThreadPool& pool) {
  const auto rows = static_cast<std::uint32_t>((model.height_px + model.stride_px - 1) / model.stride_px);
  for (Look& look : looks) {
    std::atomic<std::uint32_t> blocked{0};
    std::atomic<std::uint32_t> near{0};
    std::atomic<std::uint32_t> unknown{0};
    const auto words = static_cast<std::uint32_t>(look.blocks[0] * look.blocks[1] * look.blocks[2]) * kSeenWords;
    if (words == 0) continue;
    pool.parallel_for(rows, [&](std::uint32_t row) {
      std::uint32_t ends[3] = {0, 0, 0};
      const std::size_t v = row * static_cast<std::size_t>(model.stride_px);
      for (int u = 0; u < model.width_px; u += model.stride_px) {
        const LookEnd end = look_along(model, look, sensor_.column_slope[static_cast<std::size_t>(u)],
                                       sensor_.row_slope[v], HostBlocks{map}, [&](std::uint64_t bit) {
                                         const std::atomic_ref<std::uint32_t> word(seen_[bit / 32]);
                                         const std::uint32_t mask = 1U << (bit % 32);
                                         if ((word.load(std::memory_order_relaxed) & mask) == 0) {
                                           word.fetch_or(mask, std::memory_order_relaxed);
                                         }
                                       });
        ++ends[static_cast<std::size_t>(end)];
      }
      blocked.fetch_add(ends[static_cast<std::size_t>(LookEnd::blocked)], std::memory_order_relaxed);
      near.fetch_add(ends[static_cast<std::size_t>(LookEnd::near)], std::memory_order_relaxed);
    });
    pool.parallel_for((words + kWordsPerChunk - 1) / kWordsPerChunk, [&](std::uint32_t chunk) {
      const std::uint32_t end = std::min(words, (chunk + 1) * kWordsPerChunk);
      int bits = 0;
      for (std::uint32_t i = chunk * kWordsPerChunk; i < end; ++i) {
        bits += std::popcount(seen_[i]);
        seen_[i] = 0;
      }
      unknown.fetch_add(static_cast<std::uint32_t>(bits), std::memory_order_relaxed);
    });
    look.gain = {unknown.load(), blocked.load(), near.load(), 0};
  }
}

}  // namespace g3d::mapper::cpu
