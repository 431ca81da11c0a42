// SPDX-License-Identifier: Apache-2.0
#include "net/sync_message.hpp"

#include <cassert>
#include <cstring>

namespace g3d::net {
namespace {

constexpr std::uint8_t kind_byte(MessageKind kind) { return static_cast<std::uint8_t>(kind); }
constexpr std::uint8_t kSameLayer = 4;
/// End mark, and how far the range reaches.
constexpr std::size_t kSegmentEnd_bytes = 1 + kVarint_bytes;
constexpr std::size_t kRecordHead_bytes = 1 + 7 + 2 + 8;  ///< gap of versions, length, difference of keys
/// What a record begins with.
constexpr std::uint64_t kNoMoreRecords = 0;
constexpr std::uint64_t kVersionsLeftOut = 1;
constexpr std::uint64_t kFirstLength = 2;
static_assert(1 + 4 + 1 + kLayerId_bytes + kVarint_bytes + kRecordHead_bytes + kMostPayload_bytes + kSegmentEnd_bytes <=
                  kMostMessage_bytes,
              "the longest record fits a datagram of its own");

MessageFault take_layers(mapper::ByteReader& in, bool has_hashes, LayerList& out) {
  out.count = 0;
  while (in.left() > 0) {
    if (out.count == out.layers.size()) return MessageFault::too_many;
    LayerVersions& layer = out.layers[out.count++];
    if (!take_layer_id(in, layer.id) || !in.take_varint(layer.highest)) return MessageFault::truncated;
    if (layer.highest > kMostVersion) return MessageFault::bad_range;
    for (Version& upto : layer.upto) {
      Version less = 0;
      if (!in.take_varint(less)) return MessageFault::truncated;
      if (less > layer.highest) return MessageFault::bad_range;
      upto = layer.highest - less;
    }
    layer.content_hash = 0;
    if (has_hashes && !in.take(layer.content_hash)) return MessageFault::truncated;
  }
  return MessageFault::none;
}

MessageFault take_record(mapper::ByteReader& in, std::uint64_t head, DataRecord& record) {
  std::uint64_t gap = 0;
  std::uint64_t key = 0;
  if (head == kVersionsLeftOut && (!in.take_varint(gap) || !in.take_varint(head))) return MessageFault::truncated;
  if (head < kFirstLength) return MessageFault::bad_record;
  const std::uint64_t bytes = head - kFirstLength;
  if (gap > kMostVersion || record.version + gap + 1 > kMostVersion) return MessageFault::bad_range;
  if (!in.take_varint(key)) return MessageFault::truncated;
  record.version += gap + 1;
  record.key += from_zigzag(key);
  if (!is_record_key(record.key) || bytes > kMostPayload_bytes) return MessageFault::bad_record;
  if (!in.take_bytes(bytes, record.payload)) return MessageFault::truncated;
  return MessageFault::none;
}

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

void MessageWriter::begin_want(std::uint32_t last_seen) {
  out_.begin(kind_byte(MessageKind::want));
  out_.put(last_seen);
}

void MessageWriter::begin_data(std::uint32_t sequence) {
  out_.begin(kind_byte(MessageKind::data));
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

bool MessageWriter::add_position(const LayerPosition& position) { return out_.put_position(position); }

bool MessageWriter::begin_segment(const LayerId& layer, Lane lane, Version after, std::size_t first_bytes) {
  if (!out_.has_room(1 + kLayerId_bytes + kVarint_bytes + kRecordHead_bytes + first_bytes + kSegmentEnd_bytes))
    return false;
  const bool is_same = last_layer_ == layer;
  out_.put(static_cast<std::uint8_t>(static_cast<unsigned>(lane) | (is_same ? kSameLayer : 0U)));
  if (!is_same) out_.put_layer_id(layer);
  out_.put_varint(after);
  last_layer_ = layer;
  last_version_ = after;
  return true;
}

std::optional<std::span<std::uint8_t>> MessageWriter::add_record(RecordKey key, Version version, std::size_t bytes) {
  assert(version > last_version_ && bytes <= kMostPayload_bytes);
  if (!out_.has_room(kRecordHead_bytes + bytes + kSegmentEnd_bytes)) return std::nullopt;
  const Version gap = version - last_version_ - 1;
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

MessageFault read_beacon(mapper::ByteSpan message, std::uint64_t& digest, LayerList& layers) {
  mapper::ByteReader in(message);
  const MessageFault fault = take_head(in, kind_byte(MessageKind::beacon), digest);
  return fault != MessageFault::none ? fault : take_layers(in, false, layers);
}

MessageFault read_vector(mapper::ByteSpan message, bool& wants_answer, LayerList& layers) {
  mapper::ByteReader in(message);
  std::uint8_t flag = 0;
  const MessageFault fault = take_head(in, kind_byte(MessageKind::vector), flag);
  wants_answer = flag != 0;
  return fault != MessageFault::none ? fault : take_layers(in, true, layers);
}

MessageFault read_want(mapper::ByteSpan message, std::uint32_t& last_seen, PositionList& positions) {
  mapper::ByteReader in(message);
  if (const MessageFault fault = take_head(in, kind_byte(MessageKind::want), last_seen); fault != MessageFault::none)
    return fault;
  positions.count = 0;
  while (in.left() > 0) {
    if (positions.count == positions.positions.size()) return MessageFault::too_many;
    LayerPosition& position = positions.positions[positions.count++];
    if (const MessageFault fault = take_position(in, position); fault != MessageFault::none) return fault;
  }
  return MessageFault::none;
}

MessageFault read_data(mapper::ByteSpan message, std::uint32_t& sequence, DataVisitor* visitor) {
  mapper::ByteReader in(message);
  if (const MessageFault fault = take_head(in, kind_byte(MessageKind::data), sequence); fault != MessageFault::none)
    return fault;
  std::optional<LayerId> layer;
  DataRecord record;
  while (in.left() > 0) {
    std::uint8_t head = 0;
    if (!in.take(head)) return MessageFault::truncated;
    if ((head & 3U) >= kLanes || head > (kSameLayer | 3U) || ((head & kSameLayer) != 0 && !layer)) {
      return MessageFault::bad_record;
    }
    if ((head & kSameLayer) == 0 && !take_layer_id(in, layer.emplace())) return MessageFault::truncated;
    DataSegment segment{*layer, static_cast<Lane>(head & 3U), {}};
    if (!in.take_varint(segment.range.after)) return MessageFault::truncated;
    if (segment.range.after > kMostVersion) return MessageFault::bad_range;
    record.layer = *layer;
    record.lane = segment.lane;
    record.version = segment.range.after;
    for (;;) {
      std::uint64_t record_head = 0;
      if (!in.take_varint(record_head)) return MessageFault::truncated;
      if (record_head == kNoMoreRecords) break;
      if (const MessageFault fault = take_record(in, record_head, record); fault != MessageFault::none) return fault;
      if (visitor != nullptr) visitor->on_record(record);
    }
    std::uint64_t further = 0;
    if (!in.take_varint(further)) return MessageFault::truncated;
    segment.range.upto = record.version + further;
    if (further > kMostVersion || segment.range.upto > kMostVersion) return MessageFault::bad_range;
    if (visitor != nullptr) visitor->on_segment(segment);
  }
  return MessageFault::none;
}

}  // namespace g3d::net
