// SPDX-License-Identifier: Apache-2.0
#include "net/merged_map.hpp"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "mapper/block_source.hpp"
#include "net/pose_payload.hpp"

namespace g3d::net {
namespace {

constexpr std::size_t kMostMergedPayload_bytes = 0xFFFF;
/// Of the result every block may be due, and some that turn out to be empty.
constexpr std::size_t kMergedDuePerBlock = 2;
/// So many blocks of a submap are listed at a time. Each touches at most 4 x 4 x 4 of the result.
constexpr std::size_t kMergedSources = 256;
constexpr std::size_t kMergedTargets = 64;

}  // namespace

MergedMap::MergedMap(const MergedOptions& options)
    : options_(options), T_world_merged_(options.T_world_merged), merged_(options.grid, options.merged) {
  submaps_.reserve(options.most_submaps);
  spare_.reserve(options.most_submaps);
  for (std::size_t i = 0; i < options.most_submaps; ++i) {
    spare_.push_back(std::make_unique<mapper::VoxelMap>(options.grid, options.submap));
  }
  order_.reserve(options.most_submaps);
  payload_.reserve(kMostMergedPayload_bytes);
  keys_.reserve(std::max(options.submap.blocks, options.merged.blocks));
  due_.reserve(kMergedDuePerBlock * std::size_t{options.merged.blocks} + kMergedSources * kMergedTargets);
}

MergedMap::Submap* MergedMap::submap_of(const LayerStore& store, LayerIndex layer, std::uint32_t number) {
  const auto it = std::find_if(submaps_.begin(), submaps_.end(),
                               [&](const Submap& s) { return s.index == layer && s.number == number; });
  if (it != submaps_.end()) return &*it;
  if (submaps_.size() == options_.most_submaps) {
    ++counts_.refused_submaps;
    return nullptr;
  }
  submaps_.push_back({store.id(layer), layer, number, 0, std::move(spare_.back()), hal::Pose{}, std::nullopt});
  spare_.pop_back();
  rank_submaps();
  return &submaps_.back();
}

void MergedMap::rank_submaps() {
  const auto order = [](const Submap& s) { return std::tuple(s.layer, s.number); };
  for (Submap& submap : submaps_) {
    submap.rank = static_cast<std::uint64_t>(std::count_if(
        submaps_.begin(), submaps_.end(), [&](const Submap& other) { return order(other) < order(submap); }));
  }
}

void MergedMap::drop(LayerIndex layer) {
  const auto is_of_layer = [&](const Submap& submap) { return submap.index == layer; };
  for (Submap& submap : submaps_) {
    if (!is_of_layer(submap)) continue;
    if (submap.sampler) add_due(submap, keys_of(*submap.map));
    ++counts_.dropped_submaps;
    submap.map->clear();
    spare_.push_back(std::move(submap.map));
  }
  std::erase_if(submaps_, is_of_layer);
  rank_submaps();
}

mapper::ByteSpan MergedMap::payload_of(const LayerStore& store, const StoredRecord& record) {
  payload_.resize(record.bytes);
  store.read(record, payload_);
  return payload_;
}

void MergedMap::take_block(const LayerStore& store, LayerIndex layer, RecordKey key) {
  Submap* submap = submap_of(store, layer, submap_of_key(key));
  if (submap == nullptr) return;
  // The whole first, then the halves that are newer; or halves alone.
  values_.fill(mapper::kUnknownRgbo);
  Version whole_version = 0;
  for (const Part part : {Part::whole, Part::low_half, Part::high_half}) {
    const auto record = store.find_record(layer, with_part(key, part));
    if (!record || record->version < whole_version) continue;
    if (part == Part::whole) whole_version = record->version;
    if (unpacker_.unpack(payload_of(store, *record), part, values_) != UnpackError::none) ++counts_.bad_payloads;
  }
  const mapper::BlockKey block = block_key_of(key);
  if (!mapper::is_known(values_)) {
    (void)submap->map->erase_block(block);
  } else if (!submap->map->write_block(block, values_)) {
    ++counts_.refused_blocks;
    return;
  }
  if (submap->sampler) add_due(*submap, std::array{block});
}

void MergedMap::add_due(const Submap& submap, std::span<const mapper::BlockKey> source_keys) {
  while (!source_keys.empty()) {
    const auto some = source_keys.first(std::min(source_keys.size(), kMergedSources));
    source_keys = source_keys.subspan(some.size());
    if (due_.size() + some.size() * kMergedTargets > due_.capacity()) mapper::sort_and_drop_repeats(due_);
    submap.sampler->add_target_keys(some, due_);
  }
}

void MergedMap::take_pose(const LayerStore& store, LayerIndex layer, std::uint32_t number) {
  Submap* submap = submap_of(store, layer, number);
  const auto record = store.find_record(layer, pose_record(number));
  if (submap == nullptr || !record) return;
  const std::optional<PlacedSubmap> placed = read_pose_payload(payload_of(store, *record));
  if (!placed) {
    ++counts_.bad_payloads;
    return;
  }
  if (placed->resolution_m != options_.grid.resolution_m) {
    ++counts_.other_grids;
    return;
  }
  if (submap->sampler) {
    add_due(*submap, keys_of(*submap->map));
    ++counts_.moved_submaps;
  }
  submap->T_world_submap = placed->T_world_submap;
  look_from_there(*submap);
}

std::span<const mapper::BlockKey> MergedMap::keys_of(const mapper::VoxelMap& map) {
  keys_.clear();
  for (std::uint32_t slot = 0; slot < map.slot_end(); ++slot) {
    mapper::BlockKey block = 0;
    if (map.copy_block(slot, block, values_)) keys_.push_back(block);
  }
  return keys_;
}

void MergedMap::look_from_there(Submap& submap) {
  submap.sampler.emplace(options_.grid, submap.T_world_submap, options_.grid, T_world_merged_, mapper::Walls::closed);
  add_due(submap, keys_of(*submap.map));
}

void MergedMap::place(const hal::Pose& T_world_merged) {
  T_world_merged_ = T_world_merged;
  is_placed_anew_ = true;
}

void MergedMap::begin_update() {
  due_.clear();
  if (!is_placed_anew_) return;
  is_placed_anew_ = false;
  for (std::uint32_t slot = 0; slot < merged_.slot_end(); ++slot) {
    mapper::BlockKey block = 0;
    if (merged_.copy_block(slot, block, values_)) due_.push_back(block);
  }
  for (Submap& submap : submaps_) {
    if (submap.sampler) look_from_there(submap);
  }
}

void MergedMap::take(const LayerStore& store, LayerIndex layer, RecordKey key) {
  if (store.is_refused(layer)) return drop(layer);
  if (options_.left_out == store.id(layer) && submap_of_key(key) >= options_.left_out_from) return;
  if (kind_of(key) == RecordKind::block) take_block(store, layer, key);
  if (kind_of(key) == RecordKind::submap_pose) take_pose(store, layer, submap_of_key(key));
}

void MergedMap::update(LayerStore& store) {
  begin_update();
  store.take_changes([&](LayerIndex layer, RecordKey key) { take(store, layer, key); });
  merge_due();
}

void MergedMap::take_all(const LayerStore& store) {
  begin_update();
  for (LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
    store.for_each(layer, [&](const StoredRecord& record) { take(store, layer, record.key); });
  }
  merge_due();
}

bool MergedMap::sample_layer(std::size_t first, std::size_t end, mapper::BlockKey key) {
  bool is_known = false;
  for (std::size_t i = first; i < end; ++i) {
    if (!is_known) {
      is_known = submaps_[order_[i]].sampler->sample(key, values_);
    } else if (submaps_[order_[i]].sampler->sample(key, older_)) {
      for (std::size_t k = 0; k < values_.size(); ++k) {
        if (mapper::state_of(values_[k]) == mapper::State::unknown) values_[k] = older_[k];
      }
    }
  }
  return is_known;
}

void MergedMap::merge_due() {
  mapper::sort_and_drop_repeats(due_);
  order_.clear();
  for (std::size_t i = 0; i < submaps_.size(); ++i) {
    if (!submaps_[i].sampler) continue;
    submaps_[i].sampler->look_into(*submaps_[i].map);
    order_.push_back(i);
  }
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(submaps_[a].layer, submaps_[b].number) < std::tuple(submaps_[b].layer, submaps_[a].number);
  });
  for (const mapper::BlockKey key : due_) {
    tally_.clear();
    for (std::size_t first = 0, end = 0; first < order_.size(); first = end) {
      const Submap& newest = submaps_[order_[first]];
      while (end < order_.size() && submaps_[order_[end]].layer == newest.layer) ++end;
      if (sample_layer(first, end, key)) tally_.add(values_, newest.rank);
    }
    ++counts_.merged_blocks;
    if (!tally_.take_result(values_)) {
      (void)merged_.erase_block(key);
    } else if (!merged_.write_block(key, values_)) {
      ++counts_.refused_blocks;
    }
  }
}

}  // namespace g3d::net
