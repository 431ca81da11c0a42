// SPDX-License-Identifier: Apache-2.0
// What a journal of layers says, entry by entry: records, and what is complete of a layer by all the records before.
// Numbers are LEB128 varints unless said otherwise.
//
//   1 layer    robot (u64), incarnation (u32): of the records that follow in this frame
//   2 record   key, version, lane (u8), length, payload
//   3 claim    unclaimed (u8), position as messages have it (net/wire_parts.hpp)
//
// A disk is outside: entries are validated frame by frame before any is applied, and no frame needs another one to be
// understood. One thread.
#pragma once

#include "mapper/files/bytes.hpp"
#include "net/layer_store.hpp"
#include "net/wire_parts.hpp"

namespace g3d::net {

/// More than any entry takes.
inline constexpr std::size_t kMostEntry_bytes = 2048;
inline constexpr std::size_t kLayerEntry_bytes = 1 + kLayerId_bytes;

void add_layer_entry(mapper::Bytes& out, const LayerId& id);
/// Behind an entry of its layer in the same frame.
void add_record_entry(mapper::Bytes& out, const StoredRecord& record, mapper::ByteSpan payload);
void add_claim_entry(mapper::Bytes& out, const LayerPosition& position, bool is_unclaimed);

struct JournalRecord {
  LayerId layer;
  RecordKey key = 0;
  Version version = 0;
  Lane lane = Lane::rest;
  mapper::ByteSpan payload;
};

class JournalVisitor {
 public:
  virtual ~JournalVisitor() = default;
  virtual void on_record(const JournalRecord& record) = 0;
  virtual void on_claim(const LayerPosition& position, bool is_unclaimed) = 0;
};

enum class EntryFault : std::uint8_t {
  none,
  unknown_kind,
  truncated,
  no_layer,    ///< a record in front of which no layer stands
  bad_record,  ///< key, version, lane or length
  bad_claim,
};

/// Walks through the entries of a frame. Whoever applies them walks twice: once with no visitor, and if there is no
/// fault again.
[[nodiscard]] EntryFault read_entries(mapper::ByteSpan entries, JournalVisitor* visitor);

}  // namespace g3d::net
