// SPDX-License-Identifier: Apache-2.0
#include "net/chain_writer.hpp"

#include <algorithm>

namespace g3d::net {

using mapper::submaps::Submap;
using mapper::submaps::SubmapChain;

bool ChainWriter::is_published(RecordKey key, mapper::ByteSpan payload) const {
  const auto record = store_.find_record(gossip_.own_layer(), key);
  return record && store_.holds(*record, payload);
}

void ChainWriter::begin(Told& told, const Submap& submap) {
  ++counts_.published_submaps;
  told.last_ns = submap.last_ns;
  told.next_due = 0;
  told.due.clear();
  const mapper::VoxelMap& voxels = *submap.contents->get().voxels;
  const auto keys = submap.contents->keys();
  for (const mapper::BlockKey key : keys) {
    voxels.read_stored_block(key, values_);
    told.due.push_back({key, lane_of(key, values_, voxels.grid(), band_)});
  }
  // A join leaves out nothing that one of the two had, yet whoever holds more than is there must hear of it.
  for (const mapper::BlockKey key : told.keys) {
    if (!std::binary_search(keys.begin(), keys.end(), key)) told.due.push_back({key, Lane::ground});
  }
  std::stable_sort(told.due.begin(), told.due.end(), [](const Due& a, const Due& b) { return a.lane < b.lane; });
  told.keys.assign(keys.begin(), keys.end());
}

void ChainWriter::retract(Told& told) {
  ++counts_.retracted_submaps;
  told.is_gone = true;
  told.next_due = 0;
  told.due.clear();
  for (const mapper::BlockKey key : told.keys) told.due.push_back({key, Lane::ground});
  told.keys.clear();
}

void ChainWriter::look_at(const SubmapChain& chain) {
  const auto submaps = chain.submaps();
  for (Told& told : told_) {
    const bool is_there = std::any_of(submaps.begin(), submaps.end(),
                                      [&](const Submap& submap) { return submap.first_ns == told.first_ns; });
    if (!is_there && !told.is_gone) retract(told);
  }
  for (const Submap& submap : submaps) {
    auto told = std::find_if(told_.begin(), told_.end(), [&](const Told& t) { return t.first_ns == submap.first_ns; });
    if (told == told_.end()) {
      if (next_number_ == kMaxSubmaps - 1) {
        ++counts_.refused_submaps;
        continue;
      }
      told_.emplace_back();
      told = told_.end() - 1;
      told->first_ns = submap.first_ns;
      told->number = next_number_++;
      begin(*told, submap);
    } else if (told->last_ns != submap.last_ns) {
      begin(*told, submap);
    }
  }
}

bool ChainWriter::publish_pose(const Told& told, const Submap& submap, const Placement& placement, std::size_t& bytes) {
  const PlacementPayload payload(placement, hal::compose(placement.T_world_map, submap.T_world_stored),
                                 grid_.resolution_m);
  if (is_published(pose_record(told.number), payload.bytes())) return true;
  if (!gossip_.publish(pose_record(told.number), Lane::ground, payload.bytes())) return false;
  bytes += payload.bytes().size();
  ++counts_.published_poses;
  return true;
}

bool ChainWriter::publish_block(std::uint32_t number, const Due& due, std::size_t& bytes) {
  for (const PackedPart& part : packer_.pack_within(values_, kMostPayload_bytes)) {
    const RecordKey key = block_record(number, due.key, part.part);
    if (is_published(key, part.bytes)) continue;
    if (!gossip_.publish(key, due.lane, part.bytes)) return false;
    bytes += part.bytes.size();
  }
  ++counts_.published_blocks;
  return true;
}

std::size_t ChainWriter::publish_round(const SubmapChain& chain, const Placement& placement, std::size_t most_bytes,
                                       hal::TimeNs now_ns) {
  look_at(chain);
  std::size_t bytes = 0;
  bool has_room = true;
  const auto submap_of = [&](const Told& told) {
    const auto submaps = chain.submaps();
    return std::find_if(submaps.begin(), submaps.end(), [&](const Submap& s) { return s.first_ns == told.first_ns; });
  };
  for (const Told& told : told_) {
    if (!told.is_gone && has_room) has_room = publish_pose(told, *submap_of(told), placement, bytes);
  }
  // What has come to others before what it was joined from is gone there: nothing is unknown in between.
  for (const bool is_gone : {false, true}) {
    for (Told& told : told_) {
      if (told.is_gone != is_gone) continue;
      const mapper::VoxelMap* voxels = nullptr;
      while (has_room && told.next_due < told.due.size() && bytes <= most_bytes) {
        const Due& due = told.due[told.next_due];
        values_.fill(mapper::kUnknownRgbo);
        if (!is_gone) {
          if (voxels == nullptr) voxels = submap_of(told)->contents->get().voxels.get();
          voxels->read_stored_block(due.key, values_);
        }
        has_room = publish_block(told.number, due, bytes);
        if (has_room) ++told.next_due;
      }
    }
  }
  if (!has_room) ++counts_.refused_records;
  counts_.published_bytes += bytes;
  if (bytes > 0) gossip_.commit(now_ns);
  return bytes;
}

bool ChainWriter::is_up_to_date() const {
  return std::all_of(told_.begin(), told_.end(), [](const Told& told) { return told.next_due == told.due.size(); });
}

}  // namespace g3d::net
