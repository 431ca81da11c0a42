// SPDX-License-Identifier: Apache-2.0
#include "mapper/merge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <vector>

namespace g3d::mapper {
namespace {

using hal::Error;
using hal::Reason;
using Vector = std::array<double, 3>;

/// A pose as matrix in double precision: at 1 km a float's last bit is a tenth of a millimetre already.
struct Transform {
  std::array<double, 9> rotation;
  Vector translation_m;
  [[nodiscard]] Vector apply(const Vector& p) const {
    Vector out;
    for (std::size_t row = 0; row < 3; ++row) {
      out[row] =
          rotation[3 * row] * p[0] + rotation[3 * row + 1] * p[1] + rotation[3 * row + 2] * p[2] + translation_m[row];
    }
    return out;
  }
};

Transform transform_of(const hal::Pose& pose) {
  const auto [x, y, z, w] = hal::normalised(pose).rotation_xyzw;
  return {
      {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z),
       2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)},
      pose.translation_m};
}

/// 32767 + ceil(x / r) in double; outside of the grid for anything beyond it.
std::int32_t index_of(double x_m, double resolution_m) {
  const double k = kAxisOffset_cells + std::ceil(x_m / resolution_m);
  return k >= 0 && k < kAxisCells ? static_cast<std::int32_t>(k) : -1;
}

/// One source as seen from the target grid.
class Sampler {
 public:
  Sampler(const MergeSource& source, const Grid& target, const hal::Pose& T_world_target)
      : source_(*source.map), layer_id_(source.layer_id), target_(target) {
    const hal::Pose T_source_target = hal::compose(hal::inverse(source.T_world_map), T_world_target);
    T_source_target_ = transform_of(T_source_target);
    T_target_source_ = transform_of(hal::inverse(T_source_target));
    is_aligned_ = find_shift();
  }

  [[nodiscard]] std::uint64_t layer_id() const { return layer_id_; }

  /// Appends every target block that a known block of the source may touch.
  void add_target_keys(std::vector<BlockKey>& keys) const {
    for (const BlockKey key : source_.sorted_keys()) {
      const auto [low, high] = touched_box(block_origin(key));
      for (std::int32_t z = low.z & ~7; z <= high.z; z += kBlockSide_cells) {
        for (std::int32_t y = low.y & ~7; y <= high.y; y += kBlockSide_cells) {
          for (std::int32_t x = low.x & ~7; x <= high.x; x += kBlockSide_cells) {
            if (is_inside_grid(VoxelIndex{x, y, z})) keys.push_back(block_of({x, y, z}));
          }
        }
      }
    }
  }

  /// The source's codes (stored form) at the 512 voxels of a target block.
  void sample(BlockKey target_key, BlockValues& out) {
    const VoxelIndex origin = block_origin(target_key);
    const bool whole_blocks = is_aligned_ && shift_.x % 8 == 0 && shift_.y % 8 == 0 && shift_.z % 8 == 0;
    if (whole_blocks) {
      const VoxelIndex v{origin.x + shift_.x, origin.y + shift_.y, origin.z + shift_.z};
      if (!is_inside_grid(v) || !source_.read_stored_block(block_of(v), out)) out.fill(kUnknownRgbo);
      return;
    }
    for (std::size_t i = 0; i < out.size(); ++i) {
      const VoxelIndex place = decode(i);
      out[i] = look_up(source_voxel({origin.x + place.x, origin.y + place.y, origin.z + place.z}));
    }
  }

 private:
  /// Whether source voxel = target voxel + shift_ holds everywhere.
  [[nodiscard]] bool find_shift() {
    if (!(source_.grid() == target_)) return false;
    constexpr double kSlack = 1e-6;  // of a voxel, and over the whole grid for the rotation
    for (std::size_t i = 0; i < 9; ++i) {
      if (std::abs(T_source_target_.rotation[i] - (i % 4 == 0 ? 1.0 : 0.0)) > kSlack / kAxisCells) return false;
    }
    std::array<std::int32_t, 3> shift;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cells = T_source_target_.translation_m[axis] / static_cast<double>(target_.resolution_m);
      if (std::abs(cells) > kAxisCells || std::abs(cells - std::round(cells)) > kSlack) return false;
      shift[axis] = static_cast<std::int32_t>(std::lround(cells));
    }
    shift_ = {shift[0], shift[1], shift[2]};
    return true;
  }

  struct Box {
    VoxelIndex low, high;
  };
  /// Target voxels whose centres may fall into a source block.
  [[nodiscard]] Box touched_box(const VoxelIndex& origin) const {
    if (is_aligned_) {
      const VoxelIndex low{origin.x - shift_.x, origin.y - shift_.y, origin.z - shift_.z};
      return {low, {low.x + 7, low.y + 7, low.z + 7}};
    }
    Vector low{1e300, 1e300, 1e300};
    Vector high{-1e300, -1e300, -1e300};
    for (int corner = 0; corner < 8; ++corner) {
      const Vector at{edge_m(origin.x + (corner & 1) * 8), edge_m(origin.y + (corner >> 1 & 1) * 8),
                      edge_m(origin.z + (corner >> 2) * 8)};
      const Vector p = T_target_source_.apply(at);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
    const auto cell = [&](double x_m) {
      const double k = kAxisOffset_cells + std::ceil(x_m / static_cast<double>(target_.resolution_m));
      return static_cast<std::int32_t>(std::clamp(k, 0.0, kAxisCells - 1.0));
    };
    return {{cell(low[0]), cell(low[1]), cell(low[2])}, {cell(high[0]), cell(high[1]), cell(high[2])}};
  }
  [[nodiscard]] double edge_m(std::int32_t k) const {
    return (static_cast<double>(k) - 32768.0) * static_cast<double>(source_.grid().resolution_m);
  }

  [[nodiscard]] VoxelIndex source_voxel(const VoxelIndex& target) const {
    if (is_aligned_) return {target.x + shift_.x, target.y + shift_.y, target.z + shift_.z};
    const Vector p = T_source_target_.apply(target_.centre_m(target));
    const auto r = static_cast<double>(source_.grid().resolution_m);
    return {index_of(p[0], r), index_of(p[1], r), index_of(p[2], r)};
  }
  [[nodiscard]] Rgbo look_up(const VoxelIndex& v) {
    if (!is_inside_grid(v)) return kUnknownRgbo;
    const MCode code = encode(v);
    if (code >> kBlockShift != cached_key_) {
      cached_key_ = code >> kBlockShift;
      source_.read_stored_block(cached_key_, cached_);
    }
    return cached_[code & kPlaceMask];
  }

  const VoxelMap& source_;
  std::uint64_t layer_id_;
  Grid target_;
  Transform T_source_target_{};
  Transform T_target_source_{};
  bool is_aligned_ = false;
  VoxelIndex shift_;
  BlockKey cached_key_ = VoxelMap::kNoKey;
  BlockValues cached_{};
};

/// What is known so far of one target voxel.
struct Tally {
  std::int32_t sum = 0;  ///< of O_i - 16
  Rgbo colour = 0;       ///< stored code of the surest coloured source, 0 = none
  std::uint64_t colour_layer = 0;

  void add(Rgbo code, std::uint64_t layer) {
    sum += static_cast<std::int32_t>(level_of(code)) - kUnknownLevel;
    if ((code & kHasColourBit) == 0 || state_of(code) != State::occupied) return;
    const bool wins = colour == 0 || level_of(code) > level_of(colour) ||
                      (level_of(code) == level_of(colour) &&
                       (layer < colour_layer || (layer == colour_layer && code >> 8 < colour >> 8)));
    if (!wins) return;
    colour = code;
    colour_layer = layer;
  }
  [[nodiscard]] Rgbo result() const {
    const auto level = static_cast<Rgbo>(std::clamp(kUnknownLevel + sum, 0, static_cast<std::int32_t>(kMaxLevel)));
    return level > kUnknownLevel && colour != 0 ? (colour & 0xFFFFFF00U) | kHasColourBit | level : level;
  }
};

hal::Result<Grid> target_grid(std::span<const MergeSource> sources, const MergeOptions& options) {
  if (sources.empty()) return Error{Reason::bad_usage, "merging: no map was given; give at least one"};
  if (!hal::is_valid(options.T_world_target))
    return Error{Reason::bad_usage, "merging: the pose of the result is not a pose; check its numbers"};
  float finest_m = sources.front().map->grid().resolution_m;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (!hal::is_valid(sources[i].T_world_map))
      return Error{Reason::bad_usage,
                   fmt::format("merging: the pose of map {} is not a pose; check its numbers", i + 1)};
    finest_m = std::min(finest_m, sources[i].map->grid().resolution_m);
  }
  const float resolution_m = options.resolution_m.value_or(finest_m);
  if (!(resolution_m >= 0.0005F && resolution_m <= 100.0F)) {
    return Error{Reason::bad_usage,
                 fmt::format("merging: resolution {} m is outside of 0.0005..100 m; choose another", resolution_m)};
  }
  return Grid{resolution_m};
}

Error no_room(std::size_t blocks) {
  return {
      Reason::no_capacity,
      fmt::format("merging: {} blocks do not fit into the memory allowed; allow more or merge at a coarser resolution",
                  blocks)};
}

}  // namespace

hal::Result<std::unique_ptr<VoxelMap>> merge_maps(std::span<const MergeSource> sources, const MergeOptions& options) {
  const auto grid = target_grid(sources, options);
  if (!grid) return grid.error();
  std::vector<Sampler> samplers;
  std::vector<BlockKey> keys;
  for (const MergeSource& source : sources) {
    samplers.emplace_back(source, grid.value(), options.T_world_target);
    samplers.back().add_target_keys(keys);
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  }
  if (keys.size() > 0xFFFFFFFFU / kBricksPerBlock) return no_room(keys.size());
  const auto blocks = static_cast<std::uint32_t>(std::max<std::size_t>(keys.size(), 1));
  std::unique_ptr<VoxelMap> merged;
  try {
    merged = std::make_unique<VoxelMap>(
        grid.value(), options.capacity.value_or(MapCapacity{blocks, blocks, blocks * kBricksPerBlock}));
  } catch (const std::bad_alloc&) {
    return no_room(keys.size());
  }

  BlockValues values;
  std::array<Tally, kBlockVoxels> tallies;
  for (const BlockKey key : keys) {
    tallies.fill({});
    for (Sampler& sampler : samplers) {
      sampler.sample(key, values);
      for (std::size_t i = 0; i < values.size(); ++i) tallies[i].add(values[i], sampler.layer_id());
    }
    bool known = false;
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = tallies[i].result();
      known = known || values[i] != kUnknownRgbo;
    }
    if (known && !merged->write_block(key, values)) return no_room(keys.size());
  }
  return merged;
}

}  // namespace g3d::mapper
