// SPDX-License-Identifier: Apache-2.0
// What two robots say to each other to find out which records of a layer each lacks, as bytes; see reconciler.hpp.
//
//   sketch ask   u8 kind, layer id, salt u64 u64, first u32, count u8      send me these symbols of your records
//   sketch       u8 kind, position, u64 content hash, symbols              (set_sketch_wire.hpp), and where we stand
//   id ask       u8 kind, layer id, salt u64 u64, ids u64 ...              send me the records that these stand for
//   records      u8 kind, layer id, records                                they complete no range
//   record       u8 lane, version, length, key (zigzag difference to the one before), bytes
#pragma once

#include <cstdint>
#include <span>

#include "net/set_sketch_wire.hpp"
#include "net/wire_parts.hpp"

namespace g3d::net {

enum class ReconcileKind : std::uint8_t { sketch_ask = 16, sketch = 17, id_ask = 18, records = 19 };

struct SketchAsk {
  LayerId layer;
  SketchSalt salt;
  std::uint32_t first = 0;
  std::uint8_t count = 0;
};
struct SketchAnswer {
  LayerPosition position;
  std::uint64_t content_hash = 0;
  SketchMessage sketch;
};
inline constexpr std::size_t kMostIdsPerMessage = 140;
struct IdAsk {
  LayerId layer;
  SketchSalt salt;
  std::array<SketchId, kMostIdsPerMessage> ids{};
  std::size_t count = 0;
  [[nodiscard]] std::span<const SketchId> all() const { return {ids.data(), count}; }
};
struct LooseRecord {
  RecordKey key = 0;
  Version version = 0;
  Lane lane = Lane::rest;
  mapper::ByteSpan payload;
};

void write_sketch_ask(WireWriter& out, const SketchAsk& ask);
/// How many of the symbols, which begin with the header's first, are in it.
[[nodiscard]] std::size_t write_sketch_answer(WireWriter& out, const LayerPosition& position,
                                              std::uint64_t content_hash, const SketchHeader& header,
                                              std::span<const SketchSymbol> symbols);
/// As many of the ids as fit.
void write_id_ask(WireWriter& out, const LayerId& layer, const SketchSalt& salt, std::span<const SketchId> ids);
void begin_records(WireWriter& out, const LayerId& layer);
/// Nothing if there is no room. `last_key`: of the record before; 0 at first.
[[nodiscard]] bool add_loose_record(WireWriter& out, const LayerStore& store, const StoredRecord& record,
                                    RecordKey& last_key);

[[nodiscard]] MessageFault read_sketch_ask(mapper::ByteSpan message, SketchAsk& ask);
[[nodiscard]] MessageFault read_sketch_answer(mapper::ByteSpan message, SketchAnswer& answer);
[[nodiscard]] MessageFault read_id_ask(mapper::ByteSpan message, IdAsk& ask);

/// Walks through records: once over all to see whether there is a fault, then again with take().
class LooseRecords {
 public:
  [[nodiscard]] MessageFault open(mapper::ByteSpan message);
  [[nodiscard]] const LayerId& layer() const { return layer_; }
  /// False after the last one. After open() without a fault.
  [[nodiscard]] bool take(LooseRecord& record);

 private:
  [[nodiscard]] static MessageFault take_one(mapper::ByteReader& in, LooseRecord& record);
  LayerId layer_;
  mapper::ByteReader in_{{}};
  LooseRecord last_;
};

}  // namespace g3d::net
