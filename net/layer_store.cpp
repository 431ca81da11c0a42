// SPDX-License-Identifier: Apache-2.0
#include "net/layer_store.hpp"

#include <algorithm>
#include <cassert>

namespace g3d::net {

LayerStore::LayerStore(const StoreLimits& limits)
    : records_(limits.records), table_(limits.records), chunks_(limits.payload_bytes) {
  assert(limits.layers <= 511 && "nine bits of the table's keys, and not all of them set");
  layers_.reserve(limits.layers);
  aliases_.reserve(limits.layers);
  changes_.reserve(limits.changes);
  refused_robots_.reserve(kMostRefusedRobots);
}

LayerIndex LayerStore::find(LayerAlias alias) const {
  for (LayerIndex layer = 0; layer < layer_count(); ++layer) {
    if (aliases_[layer] == alias && !layers_[layer].is_refused) return layer;
  }
  return kNoLayer;
}

LayerIndex LayerStore::find(const LayerId& id) const {
  const LayerIndex layer = find(alias_of(id));
  return layer != kNoLayer && layers_[layer].id == id ? layer : kNoLayer;
}

LayerIndex LayerStore::find_or_add(const LayerId& id) {
  const LayerIndex known = find(alias_of(id));
  if (known != kNoLayer) return layers_[known].id == id ? known : kNoLayer;
  if (layers_.size() == layers_.capacity() || is_refused_robot(id.robot)) return kNoLayer;
  aliases_.push_back(alias_of(id));
  layers_.push_back({});
  layers_.back().id = id;
  return layer_count() - 1;
}

std::uint32_t LayerStore::slot_of(LayerIndex layer, RecordKey key) const {
  if (layers_[layer].is_refused) return kNone;
  const std::uint32_t* slot = table_.find(table_key(layer, key));
  return slot == nullptr ? kNone : *slot;
}

Version LayerStore::version_of(LayerIndex layer, RecordKey key) const {
  const std::uint32_t slot = slot_of(layer, key);
  return slot == kNone ? 0 : records_[slot].node.version;
}

bool LayerStore::is_superseded(LayerIndex layer, RecordKey key, Version version) const {
  if (version_of(layer, key) >= version) return true;
  if (kind_of(key) != RecordKind::block) return false;
  if (part_of(key) != Part::whole) return version_of(layer, with_part(key, Part::whole)) > version;
  return version_of(layer, with_part(key, Part::low_half)) > version &&
         version_of(layer, with_part(key, Part::high_half)) > version;
}

void LayerStore::drop_superseded(LayerIndex layer, RecordKey key) {
  if (kind_of(key) != RecordKind::block) return;
  const RecordKey whole = with_part(key, Part::whole);
  const RecordKey low = with_part(key, Part::low_half);
  const RecordKey high = with_part(key, Part::high_half);
  const Version whole_version = version_of(layer, whole);
  if (version_of(layer, low) > whole_version && version_of(layer, high) > whole_version) erase(layer, whole);
  for (const RecordKey half : {low, high}) {
    if (version_of(layer, half) < whole_version) erase(layer, half);
  }
}

void LayerStore::erase(LayerIndex layer, RecordKey key) {
  const std::uint32_t slot = slot_of(layer, key);
  if (slot == kNone) return;
  Record& record = records_[slot];
  Layer& of = layers_[layer];
  Nodes nodes{records_};
  Tree::erase(nodes, of.roots[static_cast<std::size_t>(record.lane)], record.node.version);
  of.content_hash -= mixed(record.key, record.node.version);
  --of.record_count;
  give_back(layer, slot);
}

void LayerStore::give_back(LayerIndex layer, std::uint32_t slot) {
  const Record& record = records_[slot];
  payload_bytes_ -= record.bytes;
  chunks_.drop(record.chain);
  table_.erase(table_key(layer, record.key));
  records_.give_back(slot);
}

LayerStore::Put LayerStore::put(LayerIndex layer, RecordKey key, Version version, Lane lane, mapper::ByteSpan payload) {
  assert(payload.size() <= 0xFFFF && is_record_key(key));
  if (is_superseded(layer, key, version)) return Put::superseded;
  const std::optional<StoredRecord> same = first_after(layer, lane, version - 1);
  if (same && same->version == version) return Put::conflicting;
  const std::uint32_t before = slot_of(layer, key);
  const std::size_t freed_bytes = before == kNone ? 0 : records_[before].bytes;
  if (layers_[layer].is_refused || (before == kNone && records_.available() == 0) ||
      !chunks_.has_room_for(payload.size(), freed_bytes)) {
    ++refused_;
    return Put::refused;
  }
  erase(layer, key);
  std::uint32_t chain = kNone;
  (void)chunks_.put(payload, chain);  // there is room
  const std::uint32_t slot = records_.take();
  *table_.find_or_insert(table_key(layer, key)) = slot;  // as many places as records
  Record& record = records_[slot];
  record = {{version}, key, chain, static_cast<std::uint16_t>(payload.size()), lane};
  Layer& of = layers_[layer];
  Nodes nodes{records_};
  Tree::insert(nodes, of.roots[static_cast<std::size_t>(lane)], slot);
  of.content_hash += mixed(key, version);
  ++of.record_count;
  payload_bytes_ += payload.size();
  drop_superseded(layer, key);
  if (changes_.size() < changes_.capacity()) changes_.push_back({layer, key});
  if (watch_ != nullptr) watch_->on_record(layer, stored(slot), payload);
  return Put::stored;
}

bool LayerStore::add_had(LayerIndex layer, Lane lane, const VersionRange& range) {
  VersionRanges& had = layers_[layer].had[static_cast<std::size_t>(lane)];
  if (had.covers(range)) return true;
  if (layers_[layer].is_refused || !had.add(range)) return false;
  if (watch_ != nullptr) watch_->on_claim(layer);
  return true;
}

void LayerStore::set_unclaimed(LayerIndex layer, bool is_unclaimed) {
  if (layers_[layer].is_refused || layers_[layer].is_unclaimed == is_unclaimed) return;
  layers_[layer].is_unclaimed = is_unclaimed;
  if (watch_ != nullptr) watch_->on_claim(layer);
}

// --- robots whose layers nobody takes

bool LayerStore::is_refused_robot(RobotId robot) const {
  return std::find(refused_robots_.begin(), refused_robots_.end(), robot) != refused_robots_.end();
}

bool LayerStore::refuse_robot(RobotId robot) {
  if (is_refused_robot(robot)) return true;
  if (refused_robots_.size() == kMostRefusedRobots) return false;
  refused_robots_.push_back(robot);
  for (LayerIndex i = 0; i < layer_count(); ++i) {
    Layer& layer = layers_[i];
    if (layer.id.robot != robot) continue;
    const LayerId id = layer.id;
    const auto roots = layer.roots;
    layer = {};
    layer.id = id;
    layer.is_refused = true;
    layer.dropped_roots = roots;
    if (changes_.size() < changes_.capacity()) changes_.push_back({i, pose_record(0)});
  }
  if (watch_ != nullptr) watch_->on_refused_robot(robot);
  return true;
}

bool LayerStore::drop_some(std::uint32_t most_records) {
  Nodes nodes{records_};
  for (LayerIndex i = 0; i < layer_count(); ++i) {
    for (std::uint32_t& root : layers_[i].dropped_roots) {
      for (; root != kNone; --most_records) {
        if (most_records == 0) return true;
        const std::uint32_t slot = Tree::erase(nodes, root, records_[root].node.version);
        give_back(i, slot);
      }
    }
  }
  return false;
}

StoredRecord LayerStore::stored(std::uint32_t slot) const {
  const Record& record = records_[slot];
  return {record.key, record.node.version, record.lane, record.bytes, slot};
}

std::optional<StoredRecord> LayerStore::find_record(LayerIndex layer, RecordKey key) const {
  const std::uint32_t slot = slot_of(layer, key);
  if (slot == kNone) return std::nullopt;
  return stored(slot);
}

std::optional<StoredRecord> LayerStore::first_after(LayerIndex layer, Lane lane, Version version) const {
  const Nodes nodes{records_};
  const std::uint32_t slot = Tree::first_after(nodes, layers_[layer].roots[static_cast<std::size_t>(lane)], version);
  if (slot == kNone) return std::nullopt;
  return stored(slot);
}

LaneVersions LayerStore::upto(LayerIndex layer) const {
  LaneVersions upto{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) upto[lane] = layers_[layer].had[lane].upto();
  return upto;
}

Version LayerStore::highest(LayerIndex layer) const {
  Version highest = 0;
  for (const VersionRanges& had : layers_[layer].had) highest = std::max(highest, had.highest());
  return highest;
}

std::uint64_t LayerStore::digest() const {
  std::uint64_t sum = 0;
  for (const Layer& layer : layers_) {
    if (layer.content_hash != 0) sum += mixed(mixed(layer.id), layer.content_hash);
  }
  return sum;
}

}  // namespace g3d::net
