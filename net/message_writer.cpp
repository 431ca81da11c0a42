// SPDX-License-Identifier: Apache-2.0
#include <cassert>

#include "net/sync_message.hpp"

namespace g3d::net {

using namespace sync_bytes;

namespace {

/// End mark, and how far the range reaches.
constexpr std::size_t kSegmentEnd_bytes = 1 + kVarint_bytes;
constexpr std::size_t kRecordHead_bytes = 1 + 7 + 2 + 8;  ///< gap of versions, length, difference of keys
constexpr std::size_t kAlias_bytes = sizeof(LayerAlias);
static_assert(1 + 2 + 1 + kAlias_bytes + kVarint_bytes + kRecordHead_bytes + kMostPayload_bytes + kSegmentEnd_bytes <=
                  kMostMessage_bytes,
              "the longest record fits a datagram of its own");

}  // namespace

void MessageWriter::begin_beacon(std::uint64_t digest) {
  out_.begin(kind_byte(MessageKind::beacon));
  out_.put(digest);
  has_hashes_ = false;
}

void MessageWriter::begin_vector(bool wants_answer) {
  out_.begin(kind_byte(MessageKind::vector));
  out_.put(static_cast<std::uint8_t>(wants_answer ? 1 : 0));
  has_hashes_ = true;
}

void MessageWriter::begin_want(const SeenNumbers& seen) {
  out_.begin(kind_byte(MessageKind::want));
  out_.put(seen.data);
  out_.put(seen.news);
  count_place_.reset();
}

void MessageWriter::begin_wants() { out_.begin(kind_byte(MessageKind::wants)); }

bool MessageWriter::begin_part(RobotAlias robot, const SeenNumbers& seen) {
  if (!out_.has_room(sizeof(robot) + sizeof(seen) + 1)) return false;
  out_.put(robot);
  out_.put(seen.data);
  out_.put(seen.news);
  count_place_ = out_.size();
  out_.put(std::uint8_t{0});
  return true;
}

void MessageWriter::begin_data(std::uint16_t sequence) { begin_segments(MessageKind::data, sequence); }

void MessageWriter::begin_news(std::uint16_t sequence) { begin_segments(MessageKind::news, sequence); }

void MessageWriter::begin_segments(MessageKind kind, std::uint16_t sequence) {
  out_.begin(kind_byte(kind));
  out_.put(sequence);
  last_layer_.reset();
  last_key_ = 0;
}

bool MessageWriter::add_layer(const LayerVersions& layer) {
  if (!out_.has_room(kLayerId_bytes + (1 + kLanes) * kVarint_bytes + sizeof(layer.content_hash))) return false;
  out_.put_layer_id(layer.id);
  out_.put_varint(layer.highest);
  for (const Version upto : layer.upto) out_.put_varint(layer.highest - upto);
  if (has_hashes_) out_.put(layer.content_hash);
  return true;
}

bool MessageWriter::add_wanted(const WantedLayer& wanted) {
  if (count_place_ && out_.at(*count_place_) == kMostWantedInPart) return false;
  if (!out_.put_wanted(wanted)) return false;
  if (count_place_) ++out_.at(*count_place_);
  return true;
}

bool MessageWriter::begin_segment(LayerAlias layer, Lane lane, Version after, std::size_t first_bytes) {
  if (!out_.has_room(1 + kAlias_bytes + kVarint_bytes + kRecordHead_bytes + first_bytes + kSegmentEnd_bytes))
    return false;
  const bool is_same = last_layer_ == layer;
  out_.put(static_cast<std::uint8_t>(static_cast<unsigned>(lane) | (is_same ? kSameLayer : 0U)));
  if (!is_same) out_.put(layer);
  out_.put_varint(after);
  last_layer_ = layer;
  last_version_ = after;
  return true;
}

std::optional<std::span<std::uint8_t>> MessageWriter::add_record(RecordKey key, Version version, std::size_t bytes) {
  assert(version > last_version_ && bytes <= kMostPayload_bytes);
  const Version gap = version - last_version_ - 1;
  const std::size_t head_bytes = (gap > 0 ? 1 + varint_bytes(gap) : 0) + varint_bytes(kFirstLength + bytes) +
                                 varint_bytes(zigzag(key - last_key_));
  if (!out_.has_room(head_bytes + bytes + kSegmentEnd_bytes)) return std::nullopt;
  if (gap > 0) {
    out_.put_varint(kVersionsLeftOut);
    out_.put_varint(gap);
  }
  out_.put_varint(kFirstLength + bytes);
  out_.put_varint(zigzag(key - last_key_));
  const std::span<std::uint8_t> place = out_.skip(bytes);
  last_version_ = version;
  last_key_ = key;
  return place;
}

void MessageWriter::end_segment(Version upto) {
  assert(upto >= last_version_);
  out_.put_varint(kNoMoreRecords);
  out_.put_varint(upto - last_version_);
}

}  // namespace g3d::net
