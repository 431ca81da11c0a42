// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/submap_chain.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "mapper/align/pose_step.hpp"
#include "mapper/block_source.hpp"
#include "mapper/merge.hpp"

namespace g3d::mapper::submaps {
namespace {

constexpr std::size_t kSurfaceSlots = std::size_t{1} << 17;  // 8 m^2 of surface are 1250 pieces of 8 cm

std::unique_ptr<VoxelMap> room_for(const Grid& grid, std::size_t blocks) {
  const auto count = static_cast<std::uint32_t>(std::max<std::size_t>(blocks, 1));
  return std::make_unique<VoxelMap>(grid, MapCapacity{count, count, count * kBricksPerBlock});
}

/// In an order of their own.
std::vector<align::DepthSample> pieces_of(const align::SurfaceMap& surfaces) {
  std::vector<align::DepthSample> pieces;
  surfaces.for_each([&](const align::SurfacePiece& piece, float /*weight*/) {
    pieces.push_back({piece.point_m, piece.normal, 1.0F});
  });
  std::sort(pieces.begin(), pieces.end(),
            [](const align::DepthSample& a, const align::DepthSample& b) { return a.point_m < b.point_m; });
  return pieces;
}

}  // namespace

SubmapChain::SubmapChain(VoxelMap& view, const ChainOptions& options)
    : view_(view),
      options_(options),
      placed_(std::make_unique<PlacedSubmaps>(view.grid())),
      is_noted_(view.capacity().blocks, 0),
      surfaces_({.slots = kSurfaceSlots}) {
  changed_slots_.reserve(is_noted_.size());
}

void SubmapChain::note(std::uint32_t slot) {
  if (is_noted_[slot] != 0) return;
  is_noted_[slot] = 1;
  changed_slots_.push_back(slot);
}

bool SubmapChain::add_frame(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera,
                            std::span<const std::uint32_t> changed_slots, std::span<const align::DepthSample> samples,
                            bool is_held) {
  if (!has_begun_) {
    has_begun_ = true;
    // What was known before the first frame: the place where the robot stands.
    for (std::uint32_t slot = 0; slot < view_.slot_end(); ++slot) {
      if (view_.header(slot).key != VoxelMap::kNoKey) note(slot);
    }
    last_camera_ = T_world_camera;
    last_ns_ = stamp_ns;
  }
  for (const std::uint32_t slot : changed_slots) note(slot);
  surfaces_.add(samples, hal::to_transform(T_world_camera), stamp_ns);
  const align::Vector6 step = align::difference(last_camera_, T_world_camera);
  way_m_ += align::shift_of(step);
  turn_rad_ += align::turn_of(step);
  if (is_held) held_s_ += static_cast<double>(stamp_ns - last_ns_) / 1e9;
  last_camera_ = T_world_camera;
  last_ns_ = stamp_ns;
  passed_.push_back({stamp_ns, T_world_camera, way_m_, turn_rad_, held_s_});
  const double since_s = static_cast<double>(stamp_ns - passed_.front().stamp_ns) / 1e9;
  return way_m_ - way_at_end_m_ >= options_.most_way_m || turn_rad_ - turn_at_end_rad_ >= options_.most_turn_rad ||
         since_s >= options_.most_s;
}

bool SubmapChain::finish_submap(std::unique_ptr<VoxelMap> space) {
  if (passed_.empty()) return false;
  Submap submap;
  submap.first_ns = passed_.front().stamp_ns;
  submap.last_ns = passed_.back().stamp_ns;
  const double middle_m = 0.5 * (way_at_end_m_ + way_m_);
  const auto anchor =
      std::find_if(passed_.begin(), passed_.end() - 1, [&](const Passed& p) { return p.way_m >= middle_m; });
  submap.anchor_ns = anchor->stamp_ns;
  submap.T_stored_anchor = anchor->T_world_camera;
  submap.way_m = anchor->way_m;
  submap.turn_rad = anchor->turn_rad;
  submap.held_s = anchor->held_s;
  held_s_ -= anchor->held_s;
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
    if (!is_known(now)) continue;
    [[maybe_unused]] const bool fits = submap.voxels->write_block(key, now);
    assert(fits);
  }
  changed_slots_.clear();
  submap.surfaces = pieces_of(surfaces_);
  const auto& at_m = submap.T_stored_anchor.translation_m;
  const align::Vector3f centre_m{static_cast<float>(at_m[0]), static_cast<float>(at_m[1]), static_cast<float>(at_m[2])};
  submap.stations.push_back({{at_m, {0, 0, 0, 1}}, PlaceSketch(submap.surfaces, centre_m)});
  surfaces_.clear();
  submap.space = std::move(space);
  submaps_.push_back(std::move(submap));
  placed_->add(*submaps_.back().voxels, submaps_.back().T_world_stored);
  return true;
}

hal::Pose SubmapChain::join(std::size_t index) {
  Submap& one = submaps_[index];
  const Submap& next = submaps_[index + 1];
  const hal::Pose T_one_next = hal::compose(hal::inverse(one.T_world_stored), next.T_world_stored);
  const hal::Pose T_next_one_anchors = hal::compose(hal::inverse(next.T_world_anchor()), one.T_world_anchor());
  PlacedSubmaps both(view_.grid());
  both.add(*one.voxels, {});
  both.add(*next.voxels, T_one_next);
  one.voxels = both.whole();

  align::SurfaceMap surfaces({.slots = kSurfaceSlots});
  surfaces.add(one.surfaces, {});
  surfaces.add(next.surfaces, hal::to_transform(T_one_next));
  one.surfaces = pieces_of(surfaces);
  if (one.space != nullptr && next.space != nullptr) {
    const std::array<MergeSource, 2> sources{{{one.space.get(), {}, 0}, {next.space.get(), T_one_next, 1}}};
    if (auto merged = merge_maps(sources); merged.ok()) one.space = std::move(merged).value();
  }
  for (const Submap::Station& station : next.stations) {
    one.stations.push_back({hal::compose(T_one_next, station.T_stored_station), station.sketch});
  }
  one.last_ns = next.last_ns;
  placed_->join(index, *one.voxels, one.T_world_stored);
  submaps_.erase(submaps_.begin() + static_cast<std::ptrdiff_t>(index) + 1);
  return T_next_one_anchors;
}

void SubmapChain::place(std::span<const hal::Pose> T_world_stored, std::unique_ptr<PlacedSubmaps> placed) {
  assert(T_world_stored.size() == submaps_.size());
  if (placed == nullptr) placed = std::make_unique<PlacedSubmaps>(view_.grid());
  for (std::size_t i = 0; i < submaps_.size(); ++i) {
    submaps_[i].T_world_stored = T_world_stored[i];
    if (i >= placed->size()) placed->add(*submaps_[i].voxels, T_world_stored[i]);
  }
  placed_ = std::move(placed);
}

void SubmapChain::rebuild() {
  assert(passed_.empty());
  const std::vector<BlockKey> keys = placed_->keys();
  BlockValues values;
  for (const BlockKey key : view_.sorted_keys()) {
    if (!std::binary_search(keys.begin(), keys.end(), key)) view_.erase_block(key);
  }
  for (const BlockKey key : keys) {
    if (read_block(key, values)) {
      refused_blocks_ += view_.write_block(key, values) ? 0 : 1;
    } else {
      view_.erase_block(key);
    }
  }
}

Surroundings SubmapChain::surroundings(std::size_t first, std::size_t end, std::size_t at) const {
  Surroundings result;
  std::vector<MergeSource> sources;
  const hal::Pose T_anchor_world = hal::inverse(submaps_[at].T_world_anchor());
  for (std::size_t i = first; i < end; ++i) {
    if (submaps_[i].space != nullptr) sources.push_back({submaps_[i].space.get(), submaps_[i].T_world_stored, i});
    const hal::RigidTransform T = hal::to_transform(hal::compose(T_anchor_world, submaps_[i].T_world_stored));
    for (align::DepthSample sample : submaps_[i].surfaces) {
      sample.point_m = align::transformed(T, sample.point_m);
      sample.normal = align::rotated(T, sample.normal);
      result.surfaces.push_back(sample);
    }
  }
  MergeOptions options;
  options.T_world_target = submaps_[at].T_world_anchor();
  if (auto merged = merge_maps(sources, options); merged.ok()) {
    result.space = std::move(merged).value();
  }
  return result;
}

hal::Pose SubmapChain::correction_at(hal::TimeNs stamp_ns) const {
  const auto after = std::upper_bound(submaps_.begin(), submaps_.end(), stamp_ns,
                                      [](hal::TimeNs t, const Submap& submap) { return t < submap.first_ns; });
  if (after == submaps_.begin() || stamp_ns > std::prev(after)->last_ns) return {};
  return std::prev(after)->T_world_stored;
}

std::uint64_t SubmapChain::memory_bytes() const {
  std::uint64_t bytes = placed_->memory_bytes();
  for (const Submap& submap : submaps_) {
    bytes += submap.voxels->memory().used_bytes + submap.surfaces.size() * sizeof(align::DepthSample) +
             submap.stations.size() * sizeof(Submap::Station) +
             (submap.space != nullptr ? submap.space->memory().used_bytes : 0);
  }
  return bytes;
}

}  // namespace g3d::mapper::submaps
