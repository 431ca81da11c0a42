// SPDX-License-Identifier: Apache-2.0
#include "mapper/map_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "mapper/wall_closing.hpp"

namespace g3d::mapper {
namespace {

using Vector = std::array<double, 3>;

/// Where a centre falls onto a face, as with half a voxel of shift, rounding must not choose the side, now this one and
/// now that.
constexpr double kFaceSlack_cells = 1e-7;

/// 32767 + ceil(u); outside of the grid for anything beyond it.
std::int32_t sampled_index(double u_cells) {
  const double k = kAxisOffset_cells + std::ceil(u_cells);
  return k >= 0 && k < kAxisCells ? static_cast<std::int32_t>(k) : -1;
}

}  // namespace

MapSampler::MapSampler(const Grid& source, const hal::Pose& T_world_map, const Grid& target,
                       const hal::Pose& T_world_target, Walls walls)
    : source_grid_(source), target_(target) {
  const hal::Pose T_source_target = hal::compose(hal::inverse(T_world_map), T_world_target);
  T_source_target_ = transform_of(T_source_target);
  T_target_source_ = transform_of(hal::inverse(T_source_target));
  cells_of_target_ = T_source_target_;
  for (double& v : cells_of_target_.rotation) v /= static_cast<double>(source.resolution_m);
  for (double& v : cells_of_target_.translation_m) {
    v = v / static_cast<double>(source.resolution_m) - kFaceSlack_cells;
  }
  is_aligned_ = find_shift();
  closes_walls_ = walls == Walls::closed && !is_aligned_ && target.resolution_m <= source.resolution_m;
}

std::array<double, 3> MapSampler::Transform::apply(const Vector& p) const {
  Vector out;
  for (std::size_t row = 0; row < 3; ++row) {
    out[row] =
        rotation[3 * row] * p[0] + rotation[3 * row + 1] * p[1] + rotation[3 * row + 2] * p[2] + translation_m[row];
  }
  return out;
}

MapSampler::Transform MapSampler::transform_of(const hal::Pose& pose) {
  const auto [x, y, z, w] = hal::normalised(pose).rotation_xyzw;
  return {
      {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z),
       2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)},
      pose.translation_m};
}

void MapSampler::add_target_keys(std::span<const BlockKey> source_keys, std::vector<BlockKey>& keys) const {
  for (const BlockKey key : source_keys) {
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

bool MapSampler::sample(BlockKey target_key, BlockValues& out) {
  const VoxelIndex origin = block_origin(target_key);
  if (takes_whole_blocks()) {
    const VoxelIndex v{origin.x + shift_.x, origin.y + shift_.y, origin.z + shift_.z};
    if (is_inside_grid(v) && source_->read_stored_block(block_of(v), out)) return true;
    out.fill(kUnknownRgbo);
    return false;
  }
  if (!has_block_near(origin)) {
    out.fill(kUnknownRgbo);
    return false;
  }
  if (!closes_walls_) {
    out.fill(kUnknownRgbo);
    sample_unknown(target_key, out);
    return true;
  }
  Centres centres;
  auto* centre = centres.data();
  for (std::int32_t z = -1; z <= kBlockSide_cells; ++z) {
    for (std::int32_t y = -1; y <= kBlockSide_cells; ++y) {
      for (std::int32_t x = -1; x <= kBlockSide_cells; ++x, ++centre) {
        *centre = centre_cells({origin.x + x, origin.y + y, origin.z + z});
        if (((x | y | z) & ~7) != 0) continue;  // beside the block
        out[place_at(x, y, z)] =
            look_up({sampled_index((*centre)[0]), sampled_index((*centre)[1]), sampled_index((*centre)[2])});
      }
    }
  }
  close_walls(*source_, centres, out);
  return true;
}

bool MapSampler::has_block_near(const VoxelIndex& target_origin) const {
  Vector low{1e300, 1e300, 1e300};
  Vector high{-1e300, -1e300, -1e300};
  for (int corner = 0; corner < 8; ++corner) {
    const Vector u =
        centre_cells({target_origin.x + ((corner & 1) != 0 ? 8 : -1), target_origin.y + ((corner & 2) != 0 ? 8 : -1),
                      target_origin.z + ((corner & 4) != 0 ? 8 : -1)});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], u[axis] - 1e-3);
      high[axis] = std::max(high[axis], u[axis] + 1e-3);
    }
  }
  std::array<std::int32_t, 3> first;
  std::array<std::int32_t, 3> last;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double end = kAxisCells - 1.0;
    first[axis] = static_cast<std::int32_t>(std::clamp(kAxisOffset_cells + std::ceil(low[axis]), 0.0, end)) & ~7;
    last[axis] = static_cast<std::int32_t>(std::clamp(kAxisOffset_cells + std::ceil(high[axis]), 0.0, end));
  }
  for (std::int32_t z = first[2]; z <= last[2]; z += kBlockSide_cells) {
    for (std::int32_t y = first[1]; y <= last[1]; y += kBlockSide_cells) {
      for (std::int32_t x = first[0]; x <= last[0]; x += kBlockSide_cells) {
        if (source_->find(block_of({x, y, z})) != kNoSlot) return true;
      }
    }
  }
  return false;
}

bool MapSampler::sample_unknown(BlockKey target_key, BlockValues& values) {
  const VoxelIndex origin = block_origin(target_key);
  bool complete = true;
  if (takes_whole_blocks()) {
    const VoxelIndex v{origin.x + shift_.x, origin.y + shift_.y, origin.z + shift_.z};
    BlockValues own;
    if (!is_inside_grid(v) || !source_->read_stored_block(block_of(v), own)) own.fill(kUnknownRgbo);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (state_of(values[i]) == State::unknown) values[i] = own[i];
      complete &= state_of(values[i]) != State::unknown;
    }
    return complete;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (state_of(values[i]) != State::unknown) continue;
    const VoxelIndex place = decode(i);
    values[i] = look_up(source_voxel({origin.x + place.x, origin.y + place.y, origin.z + place.z}));
    complete &= state_of(values[i]) != State::unknown;
  }
  return complete;
}

bool MapSampler::find_shift() {
  if (!(source_grid_ == target_)) return false;
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

MapSampler::Box MapSampler::touched_box(const VoxelIndex& origin) const {
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
  Box box{{cell(low[0]), cell(low[1]), cell(low[2])}, {cell(high[0]), cell(high[1]), cell(high[2])}};
  if (!closes_walls_) return box;
  for (std::int32_t* k : {&box.low.x, &box.low.y, &box.low.z}) *k = std::max(*k - kClosingReach_cells, 0);
  for (std::int32_t* k : {&box.high.x, &box.high.y, &box.high.z}) {
    *k = std::min(*k + kClosingReach_cells, kAxisCells - 1);
  }
  return box;
}

double MapSampler::edge_m(std::int32_t k) const {
  return (static_cast<double>(k) - 32768.0) * static_cast<double>(source_grid_.resolution_m);
}

Vector MapSampler::centre_cells(const VoxelIndex& target) const {
  return cells_of_target_.apply(target_.centre_m(target));
}

VoxelIndex MapSampler::source_voxel(const VoxelIndex& target) const {
  if (is_aligned_) return {target.x + shift_.x, target.y + shift_.y, target.z + shift_.z};
  const Vector u = centre_cells(target);
  return {sampled_index(u[0]), sampled_index(u[1]), sampled_index(u[2])};
}

Rgbo MapSampler::look_up(const VoxelIndex& v) {
  if (!is_inside_grid(v)) return kUnknownRgbo;
  const MCode code = encode(v);
  if (code >> kBlockShift != cached_key_) {
    cached_key_ = code >> kBlockShift;
    cached_slot_ = source_->find(cached_key_);
  }
  if (cached_slot_ == kNoSlot) return kUnknownRgbo;
  return stored_value(*source_, source_->header(cached_slot_), static_cast<int>(code & kPlaceMask));
}

void sort_and_drop_repeats(std::vector<BlockKey>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

}  // namespace g3d::mapper
