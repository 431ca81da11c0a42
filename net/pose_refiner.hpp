// SPDX-License-Identifier: Apache-2.0
// Where our map stands in the world, put right by others' maps: where ours and theirs show the same surfaces, it is
// fitted to them (mapper/align/map_aligner.hpp). The answer becomes a record of our own layer, a few bytes; so the
// merged map stays a function of the records, and everybody has the same.
//
// Who yields: see Placement. A layer is fitted to all layers of the lowest root that it fits to, and later again to
// those under its own root that have less depth, once there is more to compare or they have moved; then only what is
// more than `least_shift_m` or `least_turn_rad` off is published. An answer that could as well be chance is none: too
// little in common, contradicted, ambiguous or free to slide (MapAlignOutcome).
//
//   on_time():  copy the records, some at a time ──▶ beside: decode, merge, fit ──▶ on_time(): the new placement
//
// Thread: the one that gossips. Copies and what is done beside allocate.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "hal/errand.hpp"
#include "hal/messages.hpp"
#include "mapper/align/map_aligner.hpp"
#include "mapper/voxel_map.hpp"
#include "net/layer_store.hpp"
#include "net/placement.hpp"

namespace g3d::net {

struct RefinerOptions {
  mapper::Grid grid;
  mapper::MapCapacity map;        ///< of ours, of theirs together, and of one submap each
  std::size_t most_submaps = 64;  ///< on either side
  double reach_m = 0.6;           ///< how far off a pose may be that is said
  double reach_rad = 0.2;
  std::uint32_t least_records = 40;      ///< of a layer that is worth a look
  double grown_by = 1.3;                 ///< so much more there must be for another attempt
  hal::TimeNs pause_ns = 5'000'000'000;  ///< between two attempts
  double least_shift_m = 0.03;           ///< what is nearer stays as it is
  double least_turn_rad = 0.006;
  std::size_t records_per_step = 500;           ///< are copied
  bool is_lockstep = false;                     ///< the same answers at the same times: they are waited for
  hal::TimeNs answer_after_ns = 1'000'000'000;  ///< in lockstep
};

struct RefinerCounts {
  std::uint64_t attempts = 0;
  std::array<std::uint64_t, 6> outcomes{};  ///< by MapAlignOutcome
  std::uint64_t adopted_roots = 0;
  std::uint64_t corrected = 0;
  std::uint64_t left_as_it_was = 0;  ///< fitted, and not worth a record
};

class PoseRefiner {
 public:
  /// `store` outlives this. `own`: our layer in it, placed as was said.
  PoseRefiner(const RefinerOptions& options, const LayerStore& store, LayerIndex own, const hal::Pose& T_world_map);
  /// Our new placement, to be published.
  std::optional<Placement> on_time(hal::TimeNs now_ns);

  [[nodiscard]] const Placement& placement() const { return placement_; }
  [[nodiscard]] const RefinerCounts& counts() const { return counts_; }
  [[nodiscard]] const mapper::align::MapAlignment& last() const { return found_; }

 private:
  enum class Phase : std::uint8_t { idle, copying, fitting };
  /// Layers of one root that ours may be fitted to.
  struct Anchors {
    LayerId root;
    std::vector<LayerIndex> layers;
    std::uint8_t depth = 0;         ///< the greatest of theirs
    std::uint64_t records = 0;      ///< theirs
    std::uint64_t own_records = 0;  ///< ours at that time
    std::uint64_t poses = 0;        ///< changes with each of their poses
  };
  [[nodiscard]] std::vector<Anchors> all_anchors() const;
  [[nodiscard]] bool is_worth_trying(const Anchors& anchors) const;
  bool begin(hal::TimeNs now_ns);
  /// True: all is copied.
  bool copy_some();
  void fit();
  std::optional<Placement> conclude();

  RefinerOptions options_;
  const LayerStore& store_;
  LayerIndex own_;
  Placement placement_;
  RefinerCounts counts_;
  std::vector<Anchors> tried_;  ///< the last attempt of each root
  Phase phase_ = Phase::idle;
  hal::TimeNs began_ns_ = 0;
  bool has_begun_ = false;
  Anchors anchors_;  ///< of this attempt
  std::unique_ptr<LayerStore> own_copy_;
  std::unique_ptr<LayerStore> anchor_copy_;
  std::size_t copied_layers_ = 0;  ///< ours is the first
  std::size_t copied_lanes_ = 0;   ///< of the next
  Version copied_upto_ = 0;        ///< of the next lane
  std::vector<std::uint8_t> payload_;
  mapper::align::MapAlignment found_;
  hal::Errand errand_;  ///< last: its job uses the rest
};

}  // namespace g3d::net
