// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/map_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "mapper/rgbo.hpp"

namespace g3d::mapper::align {
namespace {

constexpr float kLeastCell_m = 0.08F;
constexpr float kCellVoxels = 3.0F;
constexpr float kCoarseCell_m = 0.25F;
constexpr float kCoarseVoxels = 5.0F;
constexpr std::size_t kBatch = 4096;
constexpr float kKnownBetter_m = 0.06F;
// Of the 26 neighbours at least so many more are free on one side than on the other; less is a speckle or a rod.
constexpr float kLeastLean = 2.0F;

std::size_t slots_for(std::uint64_t occupied, float voxels_per_cell) {
  const double cells = static_cast<double>(occupied) / static_cast<double>(voxels_per_cell) * 2.0 + 4096.0;
  std::size_t slots = 1;
  while (static_cast<double>(slots) < cells) slots *= 2;
  return std::min(slots, std::size_t{1} << 24);
}

SurfaceOptions options_for(const VoxelMap& map, float least_m, float voxels, float coherence) {
  const float cell_m = std::max(least_m, voxels * map.grid().resolution_m);
  return {.rule = {.cell_m = cell_m, .least_coherence = coherence}, .slots = slots_for(map.counts().occupied, voxels)};
}

/// Towards the free side; false if there is none.
bool facing(const VoxelMap& map, const VoxelIndex& v, Vector3f& normal) {
  Vector3f lean{};
  bool has_free = false;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const State state = state_of(map.at(VoxelIndex{v.x + dx, v.y + dy, v.z + dz}));
        if (state == State::unknown) continue;
        const float way = state == State::free ? 1.0F : -1.0F;
        has_free = has_free || state == State::free;
        lean[0] += way * static_cast<float>(dx);
        lean[1] += way * static_cast<float>(dy);
        lean[2] += way * static_cast<float>(dz);
      }
    }
  }
  const float length = std::sqrt(dot(lean, lean));
  if (!has_free || length < kLeastLean) return false;
  normal = {lean[0] / length, lean[1] / length, lean[2] / length};
  return true;
}

}  // namespace

MapSurfaces::MapSurfaces(const VoxelMap& map)
    : map_(map),
      tolerance_m_(std::max(0.03F, 1.5F * map.grid().resolution_m)),
      fine_(options_for(map, kLeastCell_m, kCellVoxels, 0.8F)),
      coarse_(options_for(map, kCoarseCell_m, kCoarseVoxels, 0.7F)) {
  std::vector<DepthSample> batch;
  batch.reserve(kBatch);
  const auto flush = [&] {
    fine_.add(batch, {});
    coarse_.add(batch, {});
    batch.clear();
  };
  BlockValues values;
  for (const BlockKey key : map.sorted_keys()) {
    map.read_block(key, values);
    const VoxelIndex origin = block_origin(key);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (state_of(values[i]) != State::occupied) continue;
      const VoxelIndex place = decode(i);
      const VoxelIndex v{origin.x + place.x, origin.y + place.y, origin.z + place.z};
      DepthSample sample;
      if (!facing(map, v, sample.normal)) continue;
      const auto centre = map.grid().centre_m(v);
      for (std::size_t k = 0; k < 3; ++k) sample.point_m[k] = static_cast<float>(centre[k]);
      sample.weight = 0.1F;
      batch.push_back(sample);
      if (batch.size() == kBatch) flush();
    }
  }
  flush();
  conclude();
}

MapSurfaces::MapSurfaces(const VoxelMap& map, std::span<const DepthSample> surfaces)
    : map_(map),
      tolerance_m_(kKnownBetter_m),
      fine_({.rule = {.cell_m = kLeastCell_m, .least_coherence = 0.8F}, .slots = slots_for(surfaces.size(), 1.0F)}),
      coarse_({.rule = {.cell_m = kCoarseCell_m, .least_coherence = 0.7F}, .slots = slots_for(surfaces.size(), 1.0F)}) {
  fine_.add(surfaces, {});
  coarse_.add(surfaces, {});
  conclude();
}

void MapSurfaces::conclude() {
  fine_.for_each([&](const SurfacePiece& piece, float /*weight*/) {
    samples_.push_back({piece.point_m, piece.normal, 1.0F});
  });
  // The table's order follows its size; this one is the map's own.
  std::sort(samples_.begin(), samples_.end(),
            [](const DepthSample& x, const DepthSample& y) { return x.point_m < y.point_m; });
  if (samples_.empty()) return;
  low_m_ = high_m_ = samples_.front().point_m;
  std::array<double, 3> sum{};
  for (const DepthSample& sample : samples_) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k] += static_cast<double>(sample.point_m[k]);
      low_m_[k] = std::min(low_m_[k], sample.point_m[k]);
      high_m_[k] = std::max(high_m_[k], sample.point_m[k]);
    }
  }
  for (std::size_t k = 0; k < 3; ++k) centre_m_[k] = static_cast<float>(sum[k] / static_cast<double>(samples_.size()));
}

std::vector<DepthSample> evenly(std::span<const DepthSample> samples, float spacing_m, std::size_t most) {
  for (;; spacing_m *= 1.25F) {
    std::unordered_set<std::uint64_t> taken;
    std::vector<DepthSample> chosen;
    for (const DepthSample& sample : samples) {
      if (taken.insert(cube_of(sample.point_m, spacing_m)).second) chosen.push_back(sample);
    }
    if (chosen.size() <= most) return chosen;
  }
}

}  // namespace g3d::mapper::align
