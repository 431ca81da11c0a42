// SPDX-License-Identifier: Apache-2.0
// What robots say to each other about their layers, as bytes. Numbers are LEB128 varints unless said otherwise; a
// message is read to its end before anything of it is applied.
//
//   beacon   u8 kind, u64 digest, layers               to everybody: I am here, and have these (what is new, or
//   nothing) vector   u8 kind, u8 wants_answer, layers          to one: all that I have; each layer with a u64 of its
//   contents want     u8 kind, u32 last seen, positions         to one: send me these layers beyond where I stand,
//   nothing else;
//                                                      what you sent up to `last seen` has arrived or is lost
//   data     u8 kind, u32 sequence, segments           to one: records, and which range of versions they complete
//
//   layer    robot u64, incarnation u32, highest version, how much less upto is in each of the three lanes
//   position robot u64, incarnation u32, per lane: upto, number of ranges beyond, and per range gap and length
//   segment  u8 lane | 4 if it is of the same layer as the one before, else robot u64 and incarnation u32;
//            after; records; 0; how much further than its last record the range reaches
//   record   1 and a number of versions if so many are left out; 2 + bytes; key (zigzag difference to the one before);
//            bytes
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "mapper/files/bytes.hpp"
#include "net/layer_store.hpp"
#include "net/wire_parts.hpp"

namespace g3d::net {

enum class MessageKind : std::uint8_t {
  beacon = 1,
  vector = 2,
  want = 3,
  data = 4,
  reconcile = 5,  ///< stands for those of reconcile_message.hpp, which have numbers of their own
};
inline constexpr std::size_t kMessageKinds = 6;

struct LayerVersions {
  LayerId id;
  LaneVersions upto{};
  Version highest = 0;             ///< of what is had, gaps before it or not
  std::uint64_t content_hash = 0;  ///< in vectors
};
inline constexpr std::size_t kMostLayersInMessage = 80;
inline constexpr std::size_t kMostPositionsInMessage = 70;

/// Writes one message into its own memory.
class MessageWriter {
 public:
  void begin_beacon(std::uint64_t digest);
  void begin_vector(bool wants_answer);
  void begin_want(std::uint32_t last_seen);
  void begin_data(std::uint32_t sequence);

  /// False if there is no room; the message is then as before. In beacons and vectors.
  bool add_layer(const LayerVersions& layer);
  /// In wants.
  bool add_position(const LayerPosition& position);
  /// In data. False if there is no room for it with a first record of so many bytes.
  bool begin_segment(const LayerId& layer, Lane lane, Version after, std::size_t first_bytes);
  /// Above the record before. Where its bytes are to be written; nothing if there is no room.
  [[nodiscard]] std::optional<std::span<std::uint8_t>> add_record(RecordKey key, Version version, std::size_t bytes);
  /// What the segment completes; not below its last record.
  void end_segment(Version upto);

  [[nodiscard]] mapper::ByteSpan bytes() const { return out_.bytes(); }
  [[nodiscard]] std::size_t size() const { return out_.size(); }

 private:
  WireWriter out_;
  bool has_hashes_ = false;
  std::optional<LayerId> last_layer_;
  Version last_version_ = 0;
  RecordKey last_key_ = 0;
};

/// What a message says. Spans point into it.
struct LayerList {
  std::array<LayerVersions, kMostLayersInMessage> layers;
  std::size_t count = 0;
  [[nodiscard]] std::span<const LayerVersions> all() const { return {layers.data(), count}; }
};
struct PositionList {
  std::array<LayerPosition, kMostPositionsInMessage> positions;
  std::size_t count = 0;
  [[nodiscard]] std::span<const LayerPosition> all() const { return {positions.data(), count}; }
};

[[nodiscard]] MessageFault read_beacon(mapper::ByteSpan message, std::uint64_t& digest, LayerList& layers);
[[nodiscard]] MessageFault read_vector(mapper::ByteSpan message, bool& wants_answer, LayerList& layers);
[[nodiscard]] MessageFault read_want(mapper::ByteSpan message, std::uint32_t& last_seen, PositionList& positions);

struct DataRecord {
  LayerId layer;
  Lane lane = Lane::rest;
  RecordKey key = 0;
  Version version = 0;
  mapper::ByteSpan payload;
};
struct DataSegment {
  LayerId layer;
  Lane lane = Lane::rest;
  VersionRange range;  ///< complete once its records are had
};
/// Walks through a data message: records, and after the last one of a segment the segment. Whoever applies it walks
/// twice: once with a visitor that does nothing, and if there is no fault again.
class DataVisitor {
 public:
  virtual ~DataVisitor() = default;
  virtual void on_record(const DataRecord& record) = 0;
  virtual void on_segment(const DataSegment& segment) = 0;
};
[[nodiscard]] MessageFault read_data(mapper::ByteSpan message, std::uint32_t& sequence, DataVisitor* visitor);

}  // namespace g3d::net
