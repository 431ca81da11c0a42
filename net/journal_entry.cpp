// SPDX-License-Identifier: Apache-2.0
#include "net/journal_entry.hpp"

#include <optional>

namespace g3d::net {
namespace {

enum class EntryKind : std::uint8_t { layer = 1, record, claim };

EntryFault take_record_entry(mapper::ByteReader& in, const std::optional<LayerId>& layer, JournalVisitor* visitor) {
  std::uint64_t bytes = 0;
  std::uint8_t lane = 0;
  JournalRecord record;
  if (!in.take_varint(record.key) || !in.take_varint(record.version) || !in.take(lane) || !in.take_varint(bytes)) {
    return EntryFault::truncated;
  }
  if (!layer) return EntryFault::no_layer;
  if (!is_record_key(record.key) || record.version == 0 || record.version > kMostVersion || lane >= kLanes ||
      bytes > kMostPayload_bytes) {
    return EntryFault::bad_record;
  }
  if (!in.take_bytes(static_cast<std::size_t>(bytes), record.payload)) return EntryFault::truncated;
  record.layer = *layer;
  record.lane = static_cast<Lane>(lane);
  if (visitor != nullptr) visitor->on_record(record);
  return EntryFault::none;
}

EntryFault take_claim_entry(mapper::ByteReader& in, JournalVisitor* visitor) {
  std::uint8_t is_unclaimed = 0;
  LayerPosition position;
  if (!in.take(is_unclaimed)) return EntryFault::truncated;
  const MessageFault fault = take_position(in, position);
  if (fault == MessageFault::truncated) return EntryFault::truncated;
  if (fault != MessageFault::none || is_unclaimed > 1) return EntryFault::bad_claim;
  if (visitor != nullptr) visitor->on_claim(position, is_unclaimed == 1);
  return EntryFault::none;
}

}  // namespace

void add_layer_entry(mapper::Bytes& out, const LayerId& id) {
  mapper::put(out, EntryKind::layer);
  mapper::put(out, id.robot);
  mapper::put(out, id.incarnation);
}

void add_record_entry(mapper::Bytes& out, const StoredRecord& record, mapper::ByteSpan payload) {
  mapper::put(out, EntryKind::record);
  mapper::put_varint(out, record.key);
  mapper::put_varint(out, record.version);
  mapper::put(out, record.lane);
  mapper::put_varint(out, payload.size());
  mapper::put_bytes(out, payload);
}

void add_claim_entry(mapper::Bytes& out, const LayerPosition& position, bool is_unclaimed) {
  mapper::put(out, EntryKind::claim);
  mapper::put(out, static_cast<std::uint8_t>(is_unclaimed ? 1 : 0));
  WireWriter writer;
  (void)writer.put_position(position);  // a message has room for one
  mapper::put_bytes(out, writer.bytes());
}

EntryFault read_entries(mapper::ByteSpan entries, JournalVisitor* visitor) {
  std::optional<LayerId> layer;
  mapper::ByteReader in(entries);
  while (in.left() > 0) {
    EntryKind kind{};
    EntryFault fault = EntryFault::truncated;
    if (!in.take(kind)) return fault;
    switch (kind) {
      case EntryKind::layer:
        fault = take_layer_id(in, layer.emplace()) ? EntryFault::none : EntryFault::truncated;
        break;
      case EntryKind::record:
        fault = take_record_entry(in, layer, visitor);
        break;
      case EntryKind::claim:
        fault = take_claim_entry(in, visitor);
        break;
      default:
        fault = EntryFault::unknown_kind;
    }
    if (fault != EntryFault::none) return fault;
  }
  return EntryFault::none;
}

}  // namespace g3d::net
