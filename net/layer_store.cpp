// SPDX-License-Identifier: Apache-2.0
#include "net/layer_store.hpp"

#include <algorithm>
#include <cassert>

namespace g3d::net {

LayerStore::LayerStore(const StoreLimits& limits)
    : records_(limits.records), table_(limits.records), chunks_(limits.payload_bytes) {
  assert(limits.layers <= 511 && "nine bits of the table's keys, and not all of them set");
  layers_.reserve(limits.layers);
  changes_.reserve(limits.changes);
}

LayerIndex LayerStore::find(const LayerId& id) const {
  const auto it = std::find_if(layers_.begin(), layers_.end(), [&](const Layer& layer) { return layer.id == id; });
  return it == layers_.end() ? kNoLayer : static_cast<LayerIndex>(it - layers_.begin());
}

LayerIndex LayerStore::find_or_add(const LayerId& id) {
  const LayerIndex known = find(id);
  if (known != kNoLayer) return known;
  if (layers_.size() == layers_.capacity()) return kNoLayer;
  layers_.push_back({});
  layers_.back().id = id;
  return layer_count() - 1;
}

std::uint32_t LayerStore::slot_of(LayerIndex layer, RecordKey key) const {
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
  payload_bytes_ -= record.bytes;
  chunks_.drop(record.chain);
  table_.erase(table_key(layer, key));
  records_.give_back(slot);
}

LayerStore::Put LayerStore::put(LayerIndex layer, RecordKey key, Version version, Lane lane, mapper::ByteSpan payload) {
  assert(payload.size() <= 0xFFFF && is_record_key(key));
  if (is_superseded(layer, key, version)) return Put::superseded;
  const std::optional<StoredRecord> same = first_after(layer, lane, version - 1);
  if (same && same->version == version) return Put::conflicting;
  std::uint32_t chain = kNone;
  const bool is_new = slot_of(layer, key) == kNone;
  if ((is_new && records_.available() == 0) || !chunks_.put(payload, chain)) {
    ++refused_;
    return Put::refused;
  }
  erase(layer, key);
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
  return Put::stored;
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
