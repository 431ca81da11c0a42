// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/submap_chain.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::submaps {
namespace {

/// Of `older`, what `newest` does not know. True if nothing is left to ask for.
bool fill_unknown(BlockValues& newest, const BlockValues& older) {
  bool complete = true;
  for (std::size_t i = 0; i < newest.size(); ++i) {
    if (state_of(newest[i]) == State::unknown) newest[i] = older[i];
    complete &= state_of(newest[i]) != State::unknown;
  }
  return complete;
}

bool knows_any(const BlockValues& values) {
  return std::any_of(values.begin(), values.end(), [](Rgbo v) { return state_of(v) != State::unknown; });
}

void sort_and_drop_repeats(std::vector<BlockKey>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

std::unique_ptr<VoxelMap> room_for(const Grid& grid, std::size_t blocks) {
  const auto count = static_cast<std::uint32_t>(std::max<std::size_t>(blocks, 1));
  return std::make_unique<VoxelMap>(grid, MapCapacity{count, count, count * kBricksPerBlock});
}

}  // namespace

SubmapChain::SubmapChain(VoxelMap& view, const ChainOptions& options)
    : view_(view), options_(options), is_noted_(view.capacity().blocks, 0) {
  changed_slots_.reserve(is_noted_.size());
}

void SubmapChain::note(std::uint32_t slot) {
  if (is_noted_[slot] != 0) return;
  is_noted_[slot] = 1;
  changed_slots_.push_back(slot);
}

bool SubmapChain::add_frame(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera,
                            std::span<const std::uint32_t> changed_slots) {
  if (passed_.empty() && submaps_.empty()) {
    // What was known before the first frame: the place where the robot stands.
    for (std::uint32_t slot = 0; slot < view_.slot_end(); ++slot) {
      if (view_.header(slot).key != VoxelMap::kNoKey) note(slot);
    }
    last_camera_ = T_world_camera;
  }
  for (const std::uint32_t slot : changed_slots) note(slot);
  const align::Vector6 step = align::difference(last_camera_, T_world_camera);
  way_m_ += align::shift_of(step);
  turn_rad_ += align::turn_of(step);
  last_camera_ = T_world_camera;
  passed_.push_back({stamp_ns, T_world_camera, way_m_, turn_rad_});
  const double since_s = static_cast<double>(stamp_ns - passed_.front().stamp_ns) / 1e9;
  return way_m_ - way_at_end_m_ >= options_.most_way_m || turn_rad_ - turn_at_end_rad_ >= options_.most_turn_rad ||
         since_s >= options_.most_s;
}

bool SubmapChain::finish_submap() {
  if (passed_.empty()) return false;
  Submap submap;
  submap.first_ns = passed_.front().stamp_ns;
  submap.last_ns = passed_.back().stamp_ns;
  const double middle_m = 0.5 * (way_at_end_m_ + way_m_);
  const auto anchor =
      std::find_if(passed_.begin(), passed_.end() - 1, [&](const Passed& p) { return p.way_m >= middle_m; });
  submap.T_stored_anchor = anchor->T_world_camera;
  submap.way_m = anchor->way_m;
  submap.turn_rad = anchor->turn_rad;
  way_m_ -= anchor->way_m;
  turn_rad_ -= anchor->turn_rad;
  way_at_end_m_ = way_m_;
  turn_at_end_rad_ = turn_rad_;
  passed_.clear();

  submap.voxels = room_for(view_.grid(), changed_slots_.size());
  BlockValues now;
  BlockValues before;
  for (const std::uint32_t slot : changed_slots_) {
    is_noted_[slot] = 0;
    const BlockKey key = view_.header(slot).key;
    if (!view_.read_stored_block(key, now)) continue;
    if (read_block(key, before)) {
      for (std::size_t i = 0; i < now.size(); ++i) {
        if (now[i] == before[i]) now[i] = kUnknownRgbo;
      }
    }
    if (!knows_any(now)) continue;
    [[maybe_unused]] const bool fits = submap.voxels->write_block(key, now);
    assert(fits);
  }
  changed_slots_.clear();
  submaps_.push_back(std::move(submap));
  samplers_.emplace_back();
  sample_anew(submaps_.size() - 1);
  return true;
}

void SubmapChain::sample_anew(std::size_t index) {
  Submap& submap = submaps_[index];
  samplers_[index] = std::make_unique<MapSampler>(*submap.voxels, submap.T_world_stored, view_.grid(), hal::Pose{});
  submap.view_keys.clear();
  samplers_[index]->add_target_keys(submap.view_keys);
  sort_and_drop_repeats(submap.view_keys);
}

void SubmapChain::place(std::span<const hal::Pose> T_world_stored) {
  assert(T_world_stored.size() == submaps_.size());
  for (std::size_t i = 0; i < submaps_.size(); ++i) {
    submaps_[i].T_world_stored = T_world_stored[i];
    sample_anew(i);
  }
}

bool SubmapChain::read_block(BlockKey key, std::size_t first, std::size_t end, BlockValues& out) {
  out.fill(kUnknownRgbo);
  BlockValues older;
  bool any = false;
  for (std::size_t i = end; i-- > first;) {
    const auto& keys = submaps_[i].view_keys;
    if (!std::binary_search(keys.begin(), keys.end(), key)) continue;
    samplers_[i]->sample(key, older);
    any = true;
    if (fill_unknown(out, older)) break;
  }
  return any && knows_any(out);
}

void SubmapChain::rebuild() {
  assert(passed_.empty());
  std::vector<BlockKey> keys;
  for (const Submap& submap : submaps_) keys.insert(keys.end(), submap.view_keys.begin(), submap.view_keys.end());
  sort_and_drop_repeats(keys);
  BlockValues values;
  for (const BlockKey key : view_.sorted_keys()) {
    if (!std::binary_search(keys.begin(), keys.end(), key)) view_.erase_block(key);
  }
  for (const BlockKey key : keys) {
    if (read_block(key, values)) {
      (void)view_.write_block(key, values);
    } else {
      view_.erase_block(key);
    }
  }
}

std::unique_ptr<VoxelMap> SubmapChain::joined(std::size_t first, std::size_t end, std::size_t in) const {
  std::vector<MapSampler> samplers;
  std::vector<BlockKey> keys;
  for (std::size_t i = end; i-- > first;) {
    samplers.emplace_back(*submaps_[i].voxels, submaps_[i].T_world_stored, view_.grid(), submaps_[in].T_world_stored);
    samplers.back().add_target_keys(keys);
  }
  sort_and_drop_repeats(keys);
  auto map = room_for(view_.grid(), keys.size());
  BlockValues values;
  BlockValues older;
  for (const BlockKey key : keys) {
    values.fill(kUnknownRgbo);
    for (MapSampler& sampler : samplers) {
      sampler.sample(key, older);
      if (fill_unknown(values, older)) break;
    }
    if (knows_any(values)) (void)map->write_block(key, values);
  }
  return map;
}

hal::Pose SubmapChain::correction_at(hal::TimeNs stamp_ns) const {
  const auto after = std::upper_bound(submaps_.begin(), submaps_.end(), stamp_ns,
                                      [](hal::TimeNs t, const Submap& submap) { return t < submap.first_ns; });
  if (after == submaps_.begin() || stamp_ns > std::prev(after)->last_ns) return {};
  return std::prev(after)->T_world_stored;
}

std::uint64_t SubmapChain::memory_bytes() const {
  std::uint64_t bytes = 0;
  for (const Submap& submap : submaps_) {
    bytes += submap.voxels->memory().used_bytes + submap.view_keys.size() * sizeof(BlockKey);
  }
  return bytes;
}

}  // namespace g3d::mapper::submaps
