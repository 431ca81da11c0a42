// SPDX-License-Identifier: Apache-2.0
#include "net/pose_refiner.hpp"

#include <algorithm>

#include "mapper/align/map_surfaces.hpp"
#include "mapper/align/pose_step.hpp"
#include "net/merged_map.hpp"

namespace g3d::net {
namespace {

constexpr std::uint8_t kMostDepth = 200;

/// As large as what is copied into it.
StoreLimits limits_for(std::uint64_t layers, std::uint64_t records, std::size_t payload_bytes) {
  // Room for what comes while it is copied.
  const auto most = static_cast<std::uint32_t>(records + records / 4 + 256);
  return {static_cast<std::uint32_t>(layers), most, payload_bytes + payload_bytes / 4 + 65536, 16};
}

}  // namespace

PoseRefiner::PoseRefiner(const RefinerOptions& options, const LayerStore& store, LayerIndex own,
                         const hal::Pose& T_world_map)
    : options_(options), store_(store), own_(own), placement_(Placement::as_said(T_world_map, store.id(own))) {}

std::vector<PoseRefiner::Anchors> PoseRefiner::all_anchors() const {
  std::vector<Anchors> all;
  for (LayerIndex layer = 0; layer < store_.layer_count(); ++layer) {
    if (layer == own_ || store_.record_count(layer) < options_.least_records) continue;
    const auto placed = placement_of(store_, layer);
    if (!placed || placed->depth >= kMostDepth) continue;
    const bool is_nearer =
        placed->root < placement_.root || (placed->root == placement_.root && placed->depth < placement_.depth);
    if (!is_nearer) continue;
    auto anchors = std::find_if(all.begin(), all.end(), [&](const Anchors& a) { return a.root == placed->root; });
    if (anchors == all.end()) {
      all.push_back({placed->root, {}, 0, 0, store_.record_count(own_), 0});
      anchors = all.end() - 1;
    }
    anchors->layers.push_back(layer);
    anchors->depth = std::max(anchors->depth, placed->depth);
    anchors->records += store_.record_count(layer);
    anchors->poses += mixed(mixed(store_.id(layer)), store_.find_record(layer, pose_record(0))->version);
  }
  std::sort(all.begin(), all.end(), [](const Anchors& a, const Anchors& b) { return a.root < b.root; });
  return all;
}

bool PoseRefiner::is_worth_trying(const Anchors& anchors) const {
  const auto before =
      std::find_if(tried_.begin(), tried_.end(), [&](const Anchors& a) { return a.root == anchors.root; });
  if (before == tried_.end() || before->poses != anchors.poses) return true;
  const auto has_grown = [&](std::uint64_t now, std::uint64_t then) {
    return static_cast<double>(now) > options_.grown_by * static_cast<double>(then);
  };
  return has_grown(anchors.records, before->records) || has_grown(anchors.own_records, before->own_records);
}

bool PoseRefiner::begin(hal::TimeNs now_ns) {
  if (has_begun_ && now_ns - began_ns_ < options_.pause_ns) return false;
  began_ns_ = now_ns;
  has_begun_ = true;
  if (store_.record_count(own_) < options_.least_records) return false;
  const std::vector<Anchors> all = all_anchors();
  const auto chosen = std::find_if(all.begin(), all.end(), [&](const Anchors& a) { return is_worth_trying(a); });
  if (chosen == all.end()) return false;
  anchors_ = *chosen;
  std::erase_if(tried_, [&](const Anchors& a) { return a.root == anchors_.root; });
  tried_.push_back(anchors_);
  ++counts_.attempts;
  own_copy_ = std::make_unique<LayerStore>(limits_for(1, anchors_.own_records, store_.payload_bytes()));
  anchor_copy_ =
      std::make_unique<LayerStore>(limits_for(anchors_.layers.size(), anchors_.records, store_.payload_bytes()));
  copied_layers_ = 0;
  copied_lanes_ = 0;
  copied_upto_ = 0;
  return true;
}

bool PoseRefiner::copy_some() {
  for (std::size_t count = 0; count < options_.records_per_step;) {
    if (copied_layers_ > anchors_.layers.size()) return true;
    const LayerIndex from = copied_layers_ == 0 ? own_ : anchors_.layers[copied_layers_ - 1];
    LayerStore& into = copied_layers_ == 0 ? *own_copy_ : *anchor_copy_;
    const auto record = store_.first_after(from, kAllLanes[copied_lanes_], copied_upto_);
    if (!record) {
      copied_upto_ = 0;
      if (++copied_lanes_ == kAllLanes.size()) {
        copied_lanes_ = 0;
        ++copied_layers_;
      }
      continue;
    }
    copied_upto_ = record->version;
    ++count;
    payload_.resize(record->bytes);
    store_.read(*record, payload_);
    if (const LayerIndex layer = into.find_or_add(store_.id(from)); layer != kNoLayer) {
      // What finds no room grew in the meantime: the next attempt has it.
      (void)into.put(layer, record->key, record->version, record->lane, payload_);
    }
  }
  return false;
}

void PoseRefiner::fit() {
  MergedOptions options;
  options.grid = options_.grid;
  options.merged = options_.map;
  options.submap = options_.map;
  options.most_submaps = options_.most_submaps;
  MergedMap own(options);
  own.place(placement_.T_world_map);
  own.take_all(*own_copy_);
  MergedMap anchors(options);
  anchors.take_all(*anchor_copy_);
  const mapper::align::MapSurfaces theirs(anchors.map());
  const mapper::align::MapSurfaces ours(own.map());
  mapper::align::MapAlignOptions how;
  how.reach_m = options_.reach_m;
  how.reach_rad = options_.reach_rad;
  found_ = align_maps(theirs, ours, placement_.T_world_map, how);
}

std::optional<Placement> PoseRefiner::conclude() {
  own_copy_.reset();
  anchor_copy_.reset();
  ++counts_.outcomes[static_cast<std::size_t>(found_.outcome)];
  if (found_.outcome != mapper::align::MapAlignOutcome::aligned) return std::nullopt;
  const mapper::align::Vector6 off = mapper::align::difference(placement_.T_world_map, found_.T_a_b);
  const bool is_new_root = anchors_.root < placement_.root;
  if (!is_new_root && mapper::align::shift_of(off) < options_.least_shift_m &&
      mapper::align::turn_of(off) < options_.least_turn_rad) {
    ++counts_.left_as_it_was;
    return std::nullopt;
  }
  ++(is_new_root ? counts_.adopted_roots : counts_.corrected);
  placement_ = {found_.T_a_b, anchors_.root, static_cast<std::uint8_t>(anchors_.depth + 1)};
  return placement_;
}

std::optional<Placement> PoseRefiner::on_time(hal::TimeNs now_ns) {
  if (phase_ == Phase::idle && begin(now_ns)) phase_ = Phase::copying;
  if (phase_ == Phase::copying && copy_some()) {
    phase_ = Phase::fitting;
    errand_.start([this] { fit(); });
    return std::nullopt;
  }
  if (phase_ != Phase::fitting) return std::nullopt;
  if (options_.is_lockstep) {
    if (now_ns - began_ns_ < options_.answer_after_ns) return std::nullopt;
    errand_.wait();
  }
  if (!errand_.is_done()) return std::nullopt;
  errand_.take();
  phase_ = Phase::idle;
  return conclude();
}

}  // namespace g3d::net
