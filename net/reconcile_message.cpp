// SPDX-License-Identifier: Apache-2.0
#include "net/reconcile_message.hpp"

namespace g3d::net {
namespace {

constexpr std::uint8_t byte_of_kind(ReconcileKind kind) { return static_cast<std::uint8_t>(kind); }
constexpr std::size_t kLooseHead_bytes = 1 + 3 * kVarint_bytes;
static_assert(1 + kLayerId_bytes + kLooseHead_bytes + kMostPayload_bytes <= kMostMessage_bytes);

}  // namespace

void write_sketch_ask(WireWriter& out, const SketchAsk& ask) {
  out.begin(byte_of_kind(ReconcileKind::sketch_ask));
  out.put_layer_id(ask.layer);
  out.put(ask.salt);
  out.put(ask.first);
  out.put(ask.count);
}

std::size_t write_sketch_answer(WireWriter& out, const LayerPosition& position, std::uint64_t content_hash,
                                const SketchHeader& header, std::span<const SketchSymbol> symbols) {
  out.begin(byte_of_kind(ReconcileKind::sketch));
  if (!out.put_position(position) || !out.has_room(sizeof content_hash + kSketchHeader_bytes)) return 0;
  out.put(content_hash);
  const SketchWritten written = write_sketch(header, symbols, out.rest());
  (void)out.skip(written.bytes);
  return written.symbols;
}

void write_id_ask(WireWriter& out, const LayerId& layer, const SketchSalt& salt, std::span<const SketchId> ids) {
  out.begin(byte_of_kind(ReconcileKind::id_ask));
  out.put_layer_id(layer);
  out.put(salt);
  std::size_t count = 0;
  for (const SketchId id : ids) {
    if (!out.has_room(sizeof id) || count == kMostIdsPerMessage) break;
    out.put(id);
    ++count;
  }
}

void begin_records(WireWriter& out, const LayerId& layer) {
  out.begin(byte_of_kind(ReconcileKind::records));
  out.put_layer_id(layer);
}

bool add_loose_record(WireWriter& out, const LayerStore& store, const StoredRecord& record, RecordKey& last_key) {
  if (!out.has_room(kLooseHead_bytes + record.bytes)) return false;
  out.put(static_cast<std::uint8_t>(record.lane));
  out.put_varint(record.version);
  out.put_varint(record.bytes);
  out.put_varint(zigzag(record.key - last_key));
  store.read(record, out.skip(record.bytes));
  last_key = record.key;
  return true;
}

MessageFault read_sketch_ask(mapper::ByteSpan message, SketchAsk& ask) {
  mapper::ByteReader in(message);
  const MessageFault fault = take_head(in, byte_of_kind(ReconcileKind::sketch_ask), ask.layer.robot,
                                       ask.layer.incarnation, ask.salt, ask.first, ask.count);
  if (fault != MessageFault::none) return fault;
  if (ask.count == 0 || ask.first > kMostSketchSymbols - ask.count) return MessageFault::bad_range;
  return in.left() == 0 ? MessageFault::none : MessageFault::left_over;
}

MessageFault read_sketch_answer(mapper::ByteSpan message, SketchAnswer& answer) {
  mapper::ByteReader in(message);
  if (const MessageFault fault = take_head(in, byte_of_kind(ReconcileKind::sketch)); fault != MessageFault::none) {
    return fault;
  }
  if (const MessageFault fault = take_position(in, answer.position); fault != MessageFault::none) return fault;
  if (!in.take(answer.content_hash)) return MessageFault::truncated;
  return read_sketch(message.subspan(in.offset()), answer.sketch) == SketchFault::none ? MessageFault::none
                                                                                       : MessageFault::bad_record;
}

MessageFault read_id_ask(mapper::ByteSpan message, IdAsk& ask) {
  mapper::ByteReader in(message);
  const MessageFault fault =
      take_head(in, byte_of_kind(ReconcileKind::id_ask), ask.layer.robot, ask.layer.incarnation, ask.salt);
  if (fault != MessageFault::none) return fault;
  for (ask.count = 0; in.left() > 0; ++ask.count) {
    if (ask.count == kMostIdsPerMessage) return MessageFault::too_many;
    if (!in.take(ask.ids[ask.count])) return MessageFault::truncated;
  }
  return MessageFault::none;
}

MessageFault LooseRecords::take_one(mapper::ByteReader& in, LooseRecord& record) {
  std::uint8_t lane = 0;
  std::uint64_t bytes = 0;
  std::uint64_t key = 0;
  if (!in.take(lane) || !in.take_varint(record.version) || !in.take_varint(bytes) || !in.take_varint(key)) {
    return MessageFault::truncated;
  }
  record.key += from_zigzag(key);
  if (lane >= kLanes || bytes > kMostPayload_bytes || !is_record_key(record.key)) return MessageFault::bad_record;
  if (record.version == 0 || record.version > kMostVersion) return MessageFault::bad_range;
  record.lane = static_cast<Lane>(lane);
  return in.take_bytes(bytes, record.payload) ? MessageFault::none : MessageFault::truncated;
}

MessageFault LooseRecords::open(mapper::ByteSpan message) {
  mapper::ByteReader in(message);
  const MessageFault fault = take_head(in, byte_of_kind(ReconcileKind::records), layer_.robot, layer_.incarnation);
  if (fault != MessageFault::none) return fault;
  in_ = in;
  last_ = {};
  for (LooseRecord record; in.left() > 0;) {
    if (const MessageFault of_record = take_one(in, record); of_record != MessageFault::none) return of_record;
  }
  return MessageFault::none;
}

bool LooseRecords::take(LooseRecord& record) {
  if (in_.left() == 0) return false;
  (void)take_one(in_, last_);
  record = last_;
  return true;
}

}  // namespace g3d::net
