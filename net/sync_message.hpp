// SPDX-License-Identifier: Apache-2.0
// What robots say to each other about their layers, as bytes. Numbers are LEB128 varints unless said otherwise; a
// message is read to its end before anything of it is applied.
//
// clang-format off
//   beacon   u8 kind, u64 digest, layers            to all: I am here, and have these (what is new, or nothing)
//   vector   u8 kind, u8 wants_answer, layers       to one: all that I have; each layer with a u64 of its contents
//   want     u8 kind, seen, wanted                  to one: send me these layers beyond where I stand, nothing else;
//                                                   what you sent up to `seen` has arrived or is lost
//   wants    u8 kind, parts                         to all: the same to several
//   data     u8 kind, u16 sequence, segments        to one: records, and which range of versions they complete; without
//                                                   any it asks for a want
//   news     u8 kind, u16 sequence, segments        the same to all, with sequence numbers of their own
//
//   layer    robot u64, incarnation u32, highest version, how much less upto is in each of the three lanes
//   seen     u16 of data, u16 of news: the lowest bits of the highest sequence numbers that have come
//   wanted   short name of a layer u32, what is had of its lanes (wire_parts.hpp)
//   part     short name of a robot u32, seen, number of wanted, wanted
//   segment  u8 lane | 4 if it is of the same layer as the one before, else its short name u32;
//            after; records; 0; how much further than its last record the range reaches
//   record   1 and a number of versions if so many are left out; 2 + bytes; key (zigzag difference to the one before);
//            bytes
// clang-format on
//
// Short names stand for layers that both know by their whole names, from beacons and vectors: what is not known is
// passed over, and stays wanted.
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
  news = 6,
  wants = 7,
};
inline constexpr std::size_t kMessageKinds = 8;

/// What writer and readers agree on.
namespace sync_bytes {
constexpr std::uint8_t kind_byte(MessageKind kind) { return static_cast<std::uint8_t>(kind); }
inline constexpr std::uint8_t kSameLayer = 4;
/// A part's number of wanted layers has one byte.
inline constexpr std::uint8_t kMostWantedInPart = 127;
/// What a record begins with.
inline constexpr std::uint64_t kNoMoreRecords = 0;
inline constexpr std::uint64_t kVersionsLeftOut = 1;
inline constexpr std::uint64_t kFirstLength = 2;
}  // namespace sync_bytes

/// Of what comes from one robot. Numbers begin with 1, so 0 is nothing at first.
struct SeenNumbers {
  std::uint16_t data = 0;
  std::uint16_t news = 0;
  bool operator==(const SeenNumbers&) const = default;
};

struct LayerVersions {
  LayerId id;
  LaneVersions upto{};
  Version highest = 0;             ///< of what is had, gaps before it or not
  std::uint64_t content_hash = 0;  ///< in vectors
};
inline constexpr std::size_t kMostLayersInMessage = 80;
inline constexpr std::size_t kMostWantedInMessage = 145;

/// Writes one message into its own memory.
class MessageWriter {
 public:
  void begin_beacon(std::uint64_t digest);
  void begin_vector(bool wants_answer);
  void begin_want(const SeenNumbers& seen);
  void begin_wants();
  void begin_data(std::uint16_t sequence);
  void begin_news(std::uint16_t sequence);

  /// False if there is no room; the message is then as before. In beacons and vectors.
  bool add_layer(const LayerVersions& layer);
  /// In a want, and in the last part of wants.
  bool add_wanted(const WantedLayer& wanted);
  /// In wants: for one more robot. False if there is no room for another part.
  bool begin_part(RobotAlias robot, const SeenNumbers& seen);
  /// In data and news. False if there is no room for it with a first record of so many bytes.
  bool begin_segment(LayerAlias layer, Lane lane, Version after, std::size_t first_bytes);
  /// Above the record before. Where its bytes are to be written; nothing if there is no room.
  [[nodiscard]] std::optional<std::span<std::uint8_t>> add_record(RecordKey key, Version version, std::size_t bytes);
  /// What the segment completes; not below its last record.
  void end_segment(Version upto);

  /// Forgets what was written after it had that size: of wants the last part.
  void cut(std::size_t size) { out_.cut(size); }

  [[nodiscard]] mapper::ByteSpan bytes() const { return out_.bytes(); }
  [[nodiscard]] std::size_t size() const { return out_.size(); }

 private:
  void begin_segments(MessageKind kind, std::uint16_t sequence);

  WireWriter out_;
  bool has_hashes_ = false;
  std::optional<std::size_t> count_place_;  ///< of the number of wanted in the last part
  std::optional<LayerAlias> last_layer_;
  Version last_version_ = 0;
  RecordKey last_key_ = 0;
};

/// What a message says. Spans point into it.
struct LayerList {
  std::array<LayerVersions, kMostLayersInMessage> layers;
  std::size_t count = 0;
  [[nodiscard]] std::span<const LayerVersions> all() const { return {layers.data(), count}; }
};
struct WantedList {
  std::array<WantedLayer, kMostWantedInMessage> wanted;
  std::size_t count = 0;
  [[nodiscard]] std::span<const WantedLayer> all() const { return {wanted.data(), count}; }
};

[[nodiscard]] MessageFault read_beacon(mapper::ByteSpan message, std::uint64_t& digest, LayerList& layers);
[[nodiscard]] MessageFault read_vector(mapper::ByteSpan message, bool& wants_answer, LayerList& layers);
[[nodiscard]] MessageFault read_want(mapper::ByteSpan message, SeenNumbers& seen, WantedList& wanted);
/// `seen`, `wanted`: of the part for `robot`; nothing if it has none.
[[nodiscard]] MessageFault read_wants(mapper::ByteSpan message, RobotAlias robot, std::optional<SeenNumbers>& seen,
                                      WantedList& wanted);

struct DataRecord {
  LayerAlias layer = 0;
  Lane lane = Lane::rest;
  RecordKey key = 0;
  Version version = 0;
  mapper::ByteSpan payload;
};
struct DataSegment {
  LayerAlias layer = 0;
  Lane lane = Lane::rest;
  VersionRange range;  ///< complete once its records are had
};
/// Walks through data or news: records, and after the last one of a segment the segment. Whoever applies it walks
/// twice: once with a visitor that does nothing, and if there is no fault again.
class DataVisitor {
 public:
  virtual ~DataVisitor() = default;
  virtual void on_record(const DataRecord& record) = 0;
  virtual void on_segment(const DataSegment& segment) = 0;
};
[[nodiscard]] MessageFault read_data(mapper::ByteSpan message, std::uint16_t& sequence, DataVisitor* visitor);

}  // namespace g3d::net
