// SPDX-License-Identifier: Apache-2.0
#include "net/sync_message.hpp"

namespace g3d::net {

using namespace sync_bytes;

namespace {

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

MessageFault take_wanted_list(mapper::ByteReader& in, std::size_t count, WantedList& out) {
  for (; count > 0; --count) {
    if (out.count == out.wanted.size()) return MessageFault::too_many;
    if (const MessageFault fault = take_wanted(in, out.wanted[out.count]); fault != MessageFault::none) return fault;
    ++out.count;
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

MessageFault read_want(mapper::ByteSpan message, SeenNumbers& seen, WantedList& wanted) {
  mapper::ByteReader in(message);
  wanted.count = 0;
  MessageFault fault = take_head(in, kind_byte(MessageKind::want), seen.data, seen.news);
  while (fault == MessageFault::none && in.left() > 0) fault = take_wanted_list(in, 1, wanted);
  return fault;
}

MessageFault read_wants(mapper::ByteSpan message, RobotAlias robot, std::optional<SeenNumbers>& seen,
                        WantedList& wanted) {
  mapper::ByteReader in(message);
  seen.reset();
  wanted.count = 0;
  if (const MessageFault fault = take_head(in, kind_byte(MessageKind::wants)); fault != MessageFault::none)
    return fault;
  while (in.left() > 0) {
    RobotAlias to = 0;
    SeenNumbers part;
    std::uint8_t count = 0;
    if (!in.take(to) || !in.take(part.data) || !in.take(part.news) || !in.take(count)) return MessageFault::truncated;
    if (count > kMostWantedInPart) return MessageFault::too_many;
    // Those of the others are read behind ours, and forgotten.
    const std::size_t before = wanted.count;
    if (const MessageFault fault = take_wanted_list(in, count, wanted); fault != MessageFault::none) return fault;
    if (to == robot && !seen) {
      seen = part;
    } else {
      wanted.count = before;
    }
  }
  return MessageFault::none;
}

MessageFault read_data(mapper::ByteSpan message, std::uint16_t& sequence, DataVisitor* visitor) {
  mapper::ByteReader in(message);
  const bool is_news = !message.empty() && message[0] == kind_byte(MessageKind::news);
  const std::uint8_t kind = kind_byte(is_news ? MessageKind::news : MessageKind::data);
  if (const MessageFault fault = take_head(in, kind, sequence); fault != MessageFault::none) return fault;
  std::optional<LayerAlias> layer;
  DataRecord record;
  while (in.left() > 0) {
    std::uint8_t head = 0;
    if (!in.take(head)) return MessageFault::truncated;
    if ((head & 3U) >= kLanes || head > (kSameLayer | 3U) || ((head & kSameLayer) != 0 && !layer)) {
      return MessageFault::bad_record;
    }
    if ((head & kSameLayer) == 0 && !in.take(layer.emplace())) return MessageFault::truncated;
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
