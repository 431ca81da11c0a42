// SPDX-License-Identifier: Apache-2.0
// All that one robot needs to share its map: its layer is written from its own map, gossip carries layers to and fro,
// and what the others have seen comes into the view by which it drives.
//
//   own map ─changed blocks─▶ LayerWriter ─▶ LayerStore ◀─▶ Gossip ◀─▶ radio
//      └──────▶ SharedView ◀── MergedMap of the others' layers ◀──┘
//
// With a folder to keep layers in, a restart finds them again: the own map goes on in a submap of its own, and what
// this robot had seen before counts like what others have.
//
// All calls from one thread, but for what LayerWriter says. Merging allocates: see MergedMap.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "hal/messages.hpp"
#include "mapper/voxel_map.hpp"
#include "net/chain_writer.hpp"
#include "net/gossip.hpp"
#include "net/kept_layers.hpp"
#include "net/layer_writer.hpp"
#include "net/merged_map.hpp"
#include "net/pose_refiner.hpp"
#include "net/shared_view.hpp"

namespace g3d::net {

struct SharingOptions {
  GossipOptions gossip;
  StoreLimits store;
  GroundBand band;
  std::size_t most_submaps = 16;             ///< of the others together
  hal::Pose T_world_map;                     ///< of our own map: others' are brought into its frame
  hal::TimeNs round_ns = 500'000'000;        ///< own changes are published so often
  double share_of_bandwidth = 0.5;           ///< that own news may take; the rest is for what was lost, and for others'
  hal::TimeNs merge_every_ns = 200'000'000;  ///< others' changes are taken so often
  /// Our layer is a chain of submaps (publish_chain()); what has been seen since the newest goes ahead of it.
  bool is_chain = false;
  /// Has our place in the world fitted to others' maps. Grid and room are those of our own map.
  std::optional<RefinerOptions> refine = std::nullopt;
};

class MapSharing {
 public:
  /// `own` and `link` outlive this. `kept`: with what an earlier start has left, and then as whom we write; nullptr:
  /// nothing is kept.
  MapSharing(const SharingOptions& options, const mapper::VoxelMap& own, Link& link,
             std::unique_ptr<KeptLayers> kept = nullptr);

  /// Where our map stands in the world, as it is said. Before others are heard. False if that could not be published
  /// now, as the disk has not reserved a version yet: once more then. What stands as it is, is published already.
  bool publish_pose(const hal::Pose& T_world_map, hal::TimeNs now_ns);
  /// The same by now, refined if that is wanted. view().map() is in our map's frame, and so is others().
  [[nodiscard]] const hal::Pose& T_world_map() const { return placement_.T_world_map; }
  void note_changed(std::span<const std::uint32_t> slots) { writer_.note_changed(slots); }
  /// Where our layer is a chain: what it is by now, while nobody works on it. Not what a correction has changed in the
  /// map: that the chain tells. note_changed() is for frames alone.
  void publish_chain(const mapper::submaps::SubmapChain& chain, hal::TimeNs now_ns);
  /// Nothing happens before.
  [[nodiscard]] bool is_chain_due(hal::TimeNs now_ns) const {
    return options_.is_chain && now_ns - chain_published_ns_ >= options_.round_ns;
  }
  void on_message(const Sender& from, mapper::ByteSpan message, hal::TimeNs now_ns) {
    gossip_.on_message(from, message, now_ns);
  }
  /// Every 5 to 20 ms. Returns slots of view().map() that others' news have changed, until the next call of the view.
  std::span<const std::uint32_t> on_time(hal::TimeNs now_ns);
  /// The same for a robot that drives by a view in another thread (live_view.hpp): keys of blocks of others().map()
  /// that have changed, until the next call. Leaves view() alone.
  std::span<const mapper::BlockKey> on_time_apart(hal::TimeNs now_ns);

  /// Nobody keeps what these robots have mapped: their layers go, also from the disk. Ourselves excepted.
  void drop(std::span<const RobotId> robots);
  /// Before a restart that was meant: what is left goes to the disk. Waits for it.
  void close();

  [[nodiscard]] SharedView& view() { return view_; }
  [[nodiscard]] const Gossip& gossip() const { return gossip_; }
  /// For what the robot says of itself: see TeamTalk.
  [[nodiscard]] Gossip& gossip() { return gossip_; }
  [[nodiscard]] const LayerStore& store() const { return kept_->store; }
  /// nullptr: nothing is kept.
  [[nodiscard]] const LayerKeeper* keeper() const { return kept_->keeper.get(); }
  [[nodiscard]] const LayerWriter& writer() const { return writer_; }
  [[nodiscard]] const ChainWriter& chain_writer() const { return chain_writer_; }
  [[nodiscard]] const MergedMap& others() const { return others_; }
  /// Nothing unless refining is wanted and our pose is published.
  [[nodiscard]] const PoseRefiner* refiner() const { return refiner_.get(); }

 private:
  [[nodiscard]] std::size_t bytes_per_round() const {
    const double round_s = static_cast<double>(options_.round_ns) * 1e-9;
    return static_cast<std::size_t>(options_.gossip.bandwidth_Bps * options_.share_of_bandwidth * round_s);
  }
  /// Earlier starts have written those before.
  [[nodiscard]] std::uint32_t first_submap() const { return kept_->keeper ? kept_->keeper->first_submap() : 0; }

  std::unique_ptr<KeptLayers> kept_;
  SharingOptions options_;
  Gossip gossip_;
  LayerWriter writer_;  ///< of our whole map, or of what is newer than the chain
  ChainWriter chain_writer_;
  MergedMap others_;
  SharedView view_;
  std::unique_ptr<PoseRefiner> refiner_;
  Placement placement_;
  bool is_placed_ = false;
  hal::TimeNs published_ns_ = 0;
  hal::TimeNs chain_published_ns_ = 0;
  std::uint64_t begun_submaps_ = 0;  ///< of the chain when what went ahead of it was looked through last
  hal::TimeNs merged_ns_ = 0;
};

}  // namespace g3d::net
