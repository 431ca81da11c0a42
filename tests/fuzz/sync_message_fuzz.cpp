// SPDX-License-Identifier: Apache-2.0
// Messages between robots from hostile hands: any bytes, through all four readers. At most one of them takes them; what
// it takes can be, and written again reads the same.
#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "net/sync_message.hpp"

namespace {

using namespace g3d::net;
using g3d::mapper::ByteSpan;

void check(bool holds) {
  if (!holds) std::abort();
}

bool same(const LayerVersions& a, const LayerVersions& b) {
  return a.id == b.id && a.upto == b.upto && a.highest == b.highest && a.content_hash == b.content_hash;
}

/// The readers' lists are large; they are made once.
LayerList layers, layers_again;
PositionList positions, positions_again;
MessageWriter writer;

/// A writer keeps some room that it may not need: of a full message the last layers may be missing.
std::size_t write_layers() {
  std::size_t written = 0;
  for (const LayerVersions& layer : layers.all()) {
    check(layer.highest <= kMostVersion);
    for (const Version upto : layer.upto) check(upto <= layer.highest);
    if (!writer.add_layer(layer)) break;
    ++written;
  }
  check(writer.size() <= kMostMessage_bytes);
  check(written == layers.count || writer.size() > kMostMessage_bytes - 60);
  return written;
}
void check_layers_again(std::size_t written) {
  check(layers_again.count == written);
  for (std::size_t i = 0; i < written; ++i) check(same(layers.layers[i], layers_again.layers[i]));
}

bool takes_beacon(ByteSpan message) {
  std::uint64_t digest = 0, digest_again = 0;
  if (read_beacon(message, digest, layers) != MessageFault::none) return false;
  writer.begin_beacon(digest);
  const std::size_t written = write_layers();
  check(read_beacon(writer.bytes(), digest_again, layers_again) == MessageFault::none && digest_again == digest);
  check_layers_again(written);
  return true;
}

bool takes_vector(ByteSpan message) {
  bool wants = false, wants_again = false;
  if (read_vector(message, wants, layers) != MessageFault::none) return false;
  writer.begin_vector(wants);
  const std::size_t written = write_layers();
  check(read_vector(writer.bytes(), wants_again, layers_again) == MessageFault::none && wants_again == wants);
  check_layers_again(written);
  return true;
}

bool takes_want(ByteSpan message) {
  std::uint32_t last_seen = 0, last_seen_again = 0;
  if (read_want(message, last_seen, positions) != MessageFault::none) return false;
  writer.begin_want(last_seen);
  std::size_t written = 0;
  for (const LayerPosition& position : positions.all()) {
    for (const VersionRanges& had : position.had) check(had.highest() <= kMostVersion);
    if (!writer.add_position(position)) break;
    ++written;
  }
  // Written it is never longer than what it was read from.
  check(written == positions.count || message.size() > kMostMessage_bytes);
  check(writer.size() <= std::min(message.size(), kMostMessage_bytes));
  check(read_want(writer.bytes(), last_seen_again, positions_again) == MessageFault::none);
  check(last_seen_again == last_seen && positions_again.count == written);
  for (std::size_t i = 0; i < written; ++i) {
    check(positions.positions[i].id == positions_again.positions[i].id);
    check(positions.positions[i].had == positions_again.positions[i].had);
  }
  return true;
}

/// Remembers what a data message says.
class DataListener final : public DataVisitor {
 public:
  explicit DataListener(ByteSpan message) : message_(message) {}
  void on_record(const DataRecord& record) override {
    const std::uint8_t* first = record.payload.data();
    check(first >= message_.data() && first + record.payload.size() <= message_.data() + message_.size());
    check(record.payload.size() <= kMostPayload_bytes && is_record_key(record.key) && record.version <= kMostVersion);
    check(records.size() == segment_begin_ || record.version > records.back().version);
    records.push_back(record);
  }
  void on_segment(const DataSegment& segment) override {
    check(segment.range.after <= segment.range.upto && segment.range.upto <= kMostVersion);
    for (std::size_t i = segment_begin_; i < records.size(); ++i) {
      const DataRecord& record = records[i];
      check(record.layer == segment.layer && record.lane == segment.lane);
      check(record.version > segment.range.after && record.version <= segment.range.upto);
    }
    segment_begin_ = records.size();
    segments.push_back(segment);
    ends.push_back(records.size());
  }
  std::vector<DataRecord> records;
  std::vector<DataSegment> segments;
  std::vector<std::size_t> ends;  ///< of each segment's records

 private:
  ByteSpan message_;
  std::size_t segment_begin_ = 0;
};

/// What has room of it; returns how many segments, and records.
std::pair<std::size_t, std::size_t> write_data(const DataListener& said, std::uint32_t sequence) {
  writer.begin_data(sequence);
  std::size_t record = 0;
  for (std::size_t s = 0; s < said.segments.size(); ++s) {
    const DataSegment& segment = said.segments[s];
    const std::size_t first_bytes = record < said.ends[s] ? said.records[record].payload.size() : 0;
    if (!writer.begin_segment(segment.layer, segment.lane, segment.range.after, first_bytes)) return {s, record};
    const std::size_t begin = record;
    for (; record < said.ends[s]; ++record) {
      const DataRecord& r = said.records[record];
      const auto place = writer.add_record(r.key, r.version, r.payload.size());
      check(place.has_value() || record > begin);  // the first one has its room
      if (!place) break;
      std::copy(r.payload.begin(), r.payload.end(), place->begin());
    }
    writer.end_segment(segment.range.upto);
    check(writer.size() <= kMostMessage_bytes);
    if (record < said.ends[s]) return {s + 1, record};
  }
  return {said.segments.size(), record};
}

bool takes_data(ByteSpan message) {
  std::uint32_t sequence = 0, sequence_again = 0;
  DataListener said(message);
  const MessageFault fault = read_data(message, sequence, &said);
  check(read_data(message, sequence, nullptr) == fault);
  if (fault != MessageFault::none) return false;
  const auto [segments, records] = write_data(said, sequence);
  DataListener again(writer.bytes());
  check(read_data(writer.bytes(), sequence_again, &again) == MessageFault::none && sequence_again == sequence);
  check(again.segments.size() == segments && again.records.size() == records);
  for (std::size_t i = 0; i < segments; ++i) {
    check(again.segments[i].layer == said.segments[i].layer && again.segments[i].lane == said.segments[i].lane);
    check(again.segments[i].range == said.segments[i].range);
  }
  for (std::size_t i = 0; i < records; ++i) {
    const DataRecord &a = again.records[i], &b = said.records[i];
    check(a.layer == b.layer && a.lane == b.lane && a.key == b.key && a.version == b.version);
    check(std::equal(a.payload.begin(), a.payload.end(), b.payload.begin(), b.payload.end()));
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  const ByteSpan message(data, size_bytes);
  int taken = 0;
  for (const auto takes : {takes_beacon, takes_vector, takes_want, takes_data}) taken += takes(message) ? 1 : 0;
  check(taken <= 1);
  return 0;
}
