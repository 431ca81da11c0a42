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

constexpr std::size_t kJoinedSurfaceSlots = std::size_t{1} << 18;

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

SubmapChain::SubmapChain(VoxelMap& view, const ChainOptions& options, SubmapShelf* shelf)
    : view_(view), shelf_(shelf), recorder_(view, options), placed_(std::make_unique<PlacedSubmaps>(view.grid())) {}

bool SubmapChain::finish_submap(std::unique_ptr<VoxelMap> space) {
  if (own_stretch_ == nullptr) own_stretch_ = std::make_unique<Stretch>(view_);
  if (!recorder_.take(*own_stretch_)) return false;
  add(*own_stretch_, std::move(space));
  return true;
}

void SubmapChain::add(Stretch& stretch, std::unique_ptr<VoxelMap> space) {
  Submap submap;
  submap.first_ns = stretch.first_ns;
  submap.last_ns = stretch.last_ns;
  submap.anchor_ns = stretch.anchor_ns;
  submap.T_stored_anchor = stretch.T_world_anchor;
  submap.way_m = stretch.way_m;
  submap.turn_rad = stretch.turn_rad;
  submap.held_s = stretch.held_s;

  SubmapContents contents;
  contents.voxels = map_for_blocks(view_.grid(), stretch.blocks.block_count());
  BlockValues now;
  BlockValues before;
  for (const BlockKey key : stretch.blocks.sorted_keys()) {
    stretch.blocks.read_stored_block(key, now);
    if (read_block(key, before)) {
      for (std::size_t i = 0; i < now.size(); ++i) {
        if (now[i] == before[i]) now[i] = kUnknownRgbo;
      }
    }
    if (!is_known(now)) continue;
    [[maybe_unused]] const bool fits = contents.voxels->write_block(key, now);
    assert(fits);
  }
  contents.surfaces = pieces_of(*stretch.surfaces);
  contents.space = std::move(space);
  stretch.clear();
  const auto& at_m = submap.T_stored_anchor.translation_m;
  const align::Vector3f centre_m{static_cast<float>(at_m[0]), static_cast<float>(at_m[1]), static_cast<float>(at_m[2])};
  submap.stations.push_back({{at_m, {0, 0, 0, 1}}, PlaceSketch(contents.surfaces, centre_m)});
  submap.contents = std::make_unique<ShelvedContents>(std::move(contents), shelf_);
  submaps_.push_back(std::move(submap));
  placed_->add(*submaps_.back().contents, submaps_.back().T_world_stored);
}

hal::Pose SubmapChain::join(std::size_t index) {
  Submap& one = submaps_[index];
  const Submap& next = submaps_[index + 1];
  const hal::Pose T_one_next = hal::compose(hal::inverse(one.T_world_stored), next.T_world_stored);
  const hal::Pose T_next_one_anchors = hal::compose(hal::inverse(next.T_world_anchor()), one.T_world_anchor());
  PlacedSubmaps both(view_.grid());
  both.add(*one.contents, {});
  both.add(*next.contents, T_one_next);
  SubmapContents joined;
  joined.voxels = both.whole();
  const SubmapContents& first = one.contents->get();
  const SubmapContents& second = next.contents->get();
  align::SurfaceMap surfaces({.slots = kJoinedSurfaceSlots});
  surfaces.add(first.surfaces, {});
  surfaces.add(second.surfaces, hal::to_transform(T_one_next));
  joined.surfaces = pieces_of(surfaces);
  if (first.space != nullptr && second.space != nullptr) {
    const std::array<MergeSource, 2> sources{{{first.space.get(), {}, 0}, {second.space.get(), T_one_next, 1}}};
    MergeOptions options;
    options.walls = Walls::as_centres_say;  // as the sketches have always been compared
    if (auto merged = merge_maps(sources, options); merged.ok()) joined.space = std::move(merged).value();
  }
  for (const Submap::Station& station : next.stations) {
    one.stations.push_back({hal::compose(T_one_next, station.T_stored_station), station.sketch});
  }
  one.last_ns = next.last_ns;
  one.contents = std::make_unique<ShelvedContents>(std::move(joined), shelf_);
  placed_->join(index, *one.contents, one.T_world_stored);
  submaps_.erase(submaps_.begin() + static_cast<std::ptrdiff_t>(index) + 1);
  return T_next_one_anchors;
}

std::unique_ptr<PlacedSubmaps> SubmapChain::placed_at(std::span<const hal::Pose> T_world_stored) const {
  assert(T_world_stored.size() == submaps_.size());
  auto placed = std::make_unique<PlacedSubmaps>(view_.grid());
  for (std::size_t i = 0; i < submaps_.size(); ++i) placed->add(*submaps_[i].contents, T_world_stored[i]);
  return placed;
}

void SubmapChain::place(std::span<const hal::Pose> T_world_stored, std::unique_ptr<PlacedSubmaps> placed) {
  assert(T_world_stored.size() == submaps_.size());
  placed_ = placed != nullptr ? std::move(placed) : placed_at(T_world_stored);
  for (std::size_t i = 0; i < submaps_.size(); ++i) submaps_[i].T_world_stored = T_world_stored[i];
  // What has been finished since somebody placed the others.
  for (std::size_t i = placed_->size(); i < submaps_.size(); ++i)
    placed_->add(*submaps_[i].contents, T_world_stored[i]);
}

void SubmapChain::rebuild(const std::function<bool(RegionKey)>& is_wanted) {
  assert(recorder_.is_empty());
  std::vector<BlockKey> keys = placed_->keys();
  if (is_wanted) std::erase_if(keys, [&](BlockKey key) { return !is_wanted(region_of(key)); });
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

void SubmapChain::put_away_far(const VoxelIndex& camera, std::int64_t radius_cells) {
  if (shelf_ == nullptr) return;
  for (std::size_t i = 0; i < submaps_.size(); ++i) {
    const bool is_far = placed_->squared_distance_cells(i, camera) > radius_cells * radius_cells;
    if (is_far) submaps_[i].contents->put_away();
  }
}

void SubmapChain::put_away_all_but(std::size_t kept) {
  if (shelf_ == nullptr || in_memory() <= kept) return;
  std::vector<ShelvedContents*> used;
  for (const Submap& submap : submaps_) {
    if (submap.contents->is_in_memory()) used.push_back(submap.contents.get());
  }
  std::sort(used.begin(), used.end(),
            [](const ShelvedContents* a, const ShelvedContents* b) { return a->last_use() > b->last_use(); });
  for (std::size_t i = kept; i < used.size(); ++i) used[i]->put_away();
}

std::size_t SubmapChain::in_memory() const {
  return static_cast<std::size_t>(std::count_if(submaps_.begin(), submaps_.end(),
                                                [](const Submap& submap) { return submap.contents->is_in_memory(); }));
}

Surroundings SubmapChain::surroundings(std::size_t first, std::size_t end, std::size_t at) const {
  Surroundings result;
  std::vector<MergeSource> sources;
  const hal::Pose T_anchor_world = hal::inverse(submaps_[at].T_world_anchor());
  for (std::size_t i = first; i < end; ++i) {
    const SubmapContents& contents = submaps_[i].contents->get();
    if (contents.space != nullptr) sources.push_back({contents.space.get(), submaps_[i].T_world_stored, i});
    const hal::RigidTransform T = hal::to_transform(hal::compose(T_anchor_world, submaps_[i].T_world_stored));
    for (align::DepthSample sample : contents.surfaces) {
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
    bytes += submap.contents->memory_bytes() + submap.stations.size() * sizeof(Submap::Station);
  }
  return bytes;
}

}  // namespace g3d::mapper::submaps
