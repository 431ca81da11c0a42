// SPDX-License-Identifier: Apache-2.0
#include "net/map_sharing.hpp"

namespace g3d::net {
namespace {

MergedOptions others_options(const SharingOptions& options, const mapper::VoxelMap& own) {
  MergedOptions merged;
  merged.grid = own.grid();
  merged.merged = own.capacity();
  merged.submap = own.capacity();
  merged.most_submaps = options.most_submaps;
  merged.left_out = options.gossip.self;
  return merged;
}

}  // namespace

MapSharing::MapSharing(const SharingOptions& options, const mapper::VoxelMap& own, Link& link)
    : options_(options),
      store_(options.store),
      gossip_(options.gossip, store_, link),
      writer_(own, gossip_, store_, options.band),
      others_(others_options(options, own)),
      view_(own, others_.map()) {}

std::span<const std::uint32_t> MapSharing::on_time(hal::TimeNs now_ns) {
  if (now_ns - published_ns_ >= options_.round_ns) {
    published_ns_ = now_ns;
    const double round_s = static_cast<double>(options_.round_ns) * 1e-9;
    (void)writer_.publish_round(
        static_cast<std::size_t>(options_.gossip.bandwidth_Bps * options_.share_of_bandwidth * round_s), now_ns);
  }
  gossip_.on_time(now_ns);
  if (now_ns - merged_ns_ < options_.merge_every_ns) return {};
  merged_ns_ = now_ns;
  others_.update(store_);
  return view_.on_others(others_.changed_keys());
}

}  // namespace g3d::net
