// SPDX-License-Identifier: Apache-2.0
#include "net/map_sharing.hpp"

#include <cassert>
#include <utility>

namespace g3d::net {
namespace {

/// The submap of what is newer than any of the chain.
constexpr std::uint32_t kAheadOfChain = kMaxSubmaps - 1;

SharingOptions kept_options(SharingOptions options, const LayerKeeper* keeper) {
  if (keeper == nullptr) return options;
  options.gossip.self = keeper->self();
  options.gossip.restored_upto = keeper->restored_upto();
  return options;
}

MergedOptions others_options(const SharingOptions& options, const mapper::VoxelMap& own, std::uint32_t first_submap) {
  MergedOptions merged;
  merged.grid = own.grid();
  merged.merged = own.capacity();
  merged.submap = own.capacity();
  merged.most_submaps = options.most_submaps;
  merged.left_out = options.gossip.self;
  merged.left_out_from = first_submap;
  merged.T_world_merged = options.T_world_map;
  return merged;
}

}  // namespace

MapSharing::MapSharing(const SharingOptions& options, const mapper::VoxelMap& own, Link& link,
                       std::unique_ptr<KeptLayers> kept)
    : kept_(kept ? std::move(kept) : std::make_unique<KeptLayers>(options.store)),
      options_(kept_options(options, keeper())),
      gossip_(options_.gossip, kept_->store, link),
      writer_(own, gossip_, kept_->store, options.band, options.is_chain ? kAheadOfChain : first_submap()),
      chain_writer_(gossip_, kept_->store, own.grid(), options.band),
      others_(others_options(options_, own, first_submap())),
      view_(own, others_.map()) {
  assert(!(options_.is_chain && keeper() != nullptr) && "a chain numbers its submaps from 0");
  if (keeper() != nullptr) gossip_.set_version_limit(keeper()->version_limit());
  if (!options_.refine) return;
  options_.refine->grid = own.grid();
  options_.refine->map = own.capacity();
}

bool MapSharing::publish_pose(const hal::Pose& T_world_map, hal::TimeNs now_ns) {
  if (!is_placed_) {
    is_placed_ = true;
    placement_ = Placement::as_said(T_world_map, options_.gossip.self);
    others_.place(T_world_map);
    if (options_.refine) {
      refiner_ = std::make_unique<PoseRefiner>(*options_.refine, kept_->store, gossip_.own_layer(), T_world_map);
    }
  }
  return writer_.publish_pose(T_world_map, now_ns);
}

void MapSharing::drop(std::span<const RobotId> robots) {
  for (const RobotId robot : robots) {
    if (robot != options_.gossip.self.robot) (void)kept_->store.refuse_robot(robot);
  }
}

void MapSharing::close() {
  if (kept_->keeper) kept_->keeper->close(gossip_.version());
}

void MapSharing::publish_chain(const mapper::submaps::SubmapChain& chain, hal::TimeNs now_ns) {
  if (!is_chain_due(now_ns)) return;
  chain_published_ns_ = now_ns;
  (void)chain_writer_.publish_round(chain, placement_, bytes_per_round(), now_ns);
  const std::uint64_t begun = chain_writer_.counts().published_submaps;
  if (begun == begun_submaps_ || !chain_writer_.is_up_to_date()) return;
  begun_submaps_ = begun;
  writer_.withdraw_unless([&](std::uint32_t slot) { return chain.recorder().is_noted(slot); });
}

std::span<const std::uint32_t> MapSharing::on_time(hal::TimeNs now_ns) {
  const std::span<const mapper::BlockKey> keys = on_time_apart(now_ns);
  return keys.empty() ? std::span<const std::uint32_t>{} : view_.on_others(keys);
}

std::span<const mapper::BlockKey> MapSharing::on_time_apart(hal::TimeNs now_ns) {
  if (now_ns - published_ns_ >= options_.round_ns) {
    published_ns_ = now_ns;
    (void)writer_.publish_round(bytes_per_round(), now_ns);
  }
  if (refiner_ != nullptr) {
    if (const auto placed = refiner_->on_time(now_ns)) {
      placement_ = *placed;
      others_.place(placement_.T_world_map);
    }
    // Again and again until there is room for it.
    (void)writer_.publish_placement(placement_, now_ns);
  }
  gossip_.on_time(now_ns);
  if (kept_->keeper) {
    kept_->keeper->on_time(gossip_.version(), now_ns);
    gossip_.set_version_limit(kept_->keeper->version_limit());
  }
  if (now_ns - merged_ns_ < options_.merge_every_ns) return {};
  merged_ns_ = now_ns;
  others_.update(kept_->store);
  return others_.changed_keys();
}

}  // namespace g3d::net
