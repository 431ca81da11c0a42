// SPDX-License-Identifier: Apache-2.0
#include "net/layer_writer.hpp"

#include <algorithm>

namespace g3d::net {

Lane lane_of(mapper::BlockKey key, const mapper::BlockValues& values, const mapper::Grid& grid,
             const GroundBand& band) {
  const std::int32_t low = mapper::block_origin(key).z;
  // Voxel k covers ((k - 32768) r, (k - 32767) r].
  const float bottom_m = static_cast<float>(low - 32768) * grid.resolution_m;
  const float top_m = bottom_m + static_cast<float>(mapper::kBlockSide_cells) * grid.resolution_m;
  if (top_m > band.low_m && bottom_m < band.high_m) return Lane::ground;
  bool has_free = false;
  bool has_unknown = false;
  for (const mapper::Rgbo value : values) {
    const mapper::State state = mapper::state_of(value);
    has_free = has_free || state == mapper::State::free;
    has_unknown = has_unknown || state == mapper::State::unknown;
  }
  return has_free && has_unknown ? Lane::frontier : Lane::rest;
}

LayerWriter::LayerWriter(const mapper::VoxelMap& map, Gossip& gossip, const LayerStore& store, const GroundBand& band,
                         std::uint32_t submap)
    : map_(map),
      gossip_(gossip),
      store_(store),
      band_(band),
      submap_(submap),
      dirty_(map.capacity().blocks),
      withdrawn_(map.capacity().blocks),
      told_(map.capacity().blocks) {
  due_.reserve(2 * std::size_t{map.capacity().blocks});
}

bool LayerWriter::publish_placement(const Placement& placement, hal::TimeNs now_ns) {
  const PlacementPayload payload(placement, placement.T_world_map, map_.grid().resolution_m);
  if (is_published(pose_record(submap_), payload.bytes())) return true;
  if (!gossip_.publish(pose_record(submap_), Lane::ground, payload.bytes())) return false;
  gossip_.commit(now_ns);
  return true;
}

bool LayerWriter::is_published(RecordKey key, mapper::ByteSpan payload) const {
  const auto record = store_.find_record(gossip_.own_layer(), key);
  return record && store_.holds(*record, payload);
}

void LayerWriter::collect() {
  due_.clear();
  withdrawn_.take_each([&](std::uint32_t slot) {
    if (told_[slot] != 0) due_.push_back({Lane::ground, told_[slot] - 1, slot, true, true});
  });
  dirty_.take_each([&](std::uint32_t slot) {
    mapper::BlockKey key = 0;
    const bool is_there = map_.copy_block(slot, key, values_);
    const mapper::BlockKey told = told_[slot];
    if (told != 0 && (!is_there || told != key + 1)) due_.push_back({Lane::ground, told - 1, slot, true});
    if (is_there) due_.push_back({lane_of(key, values_, map_.grid(), band_), key, slot, false});
  });
  std::sort(due_.begin(), due_.end());
}

bool LayerWriter::publish(const Due& due, std::size_t& bytes) {
  if (due.is_gone) {
    values_.fill(mapper::kUnknownRgbo);
  } else {
    mapper::BlockKey key = 0;
    // It may have left since: then it is noted again.
    if (!map_.copy_block(due.slot, key, values_) || key != due.key) return true;
  }
  const std::span<const PackedPart> parts = packer_.pack_within(values_, kMostPayload_bytes);
  const bool is_told = std::all_of(parts.begin(), parts.end(), [&](const PackedPart& part) {
    return is_published(block_record(submap_, due.key, part.part), part.bytes);
  });
  if (is_told) {
    ++counts_.unchanged_blocks;
  } else {
    for (const PackedPart& part : parts) {
      if (!gossip_.publish(block_record(submap_, due.key, part.part), due.lane, part.bytes)) return false;
      bytes += part.bytes.size();
    }
    ++counts_.published_blocks;
  }
  if (due.is_gone) {
    if (told_[due.slot] == due.key + 1) told_[due.slot] = 0;
  } else {
    told_[due.slot] = due.key + 1;
  }
  return true;
}

std::size_t LayerWriter::publish_round(std::size_t most_bytes, hal::TimeNs now_ns) {
  collect();
  std::size_t bytes = 0;
  for (const Due& due : due_) {
    if (bytes > most_bytes) {
      ++counts_.put_off_blocks;
      note_again(due);
    } else if (!publish(due, bytes)) {
      ++counts_.refused_blocks;
      note_again(due);
    }
  }
  counts_.published_bytes += bytes;
  if (bytes > 0) gossip_.commit(now_ns);
  return bytes;
}

}  // namespace g3d::net
