// SPDX-License-Identifier: Apache-2.0
// Messages between robots from hostile hands: any bytes, through all five readers. At most one of them takes them; what
// it takes can be, and written again reads the same.
#include <algorithm>
#include <cstdlib>
#include <optional>
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
WantedList wanted, wanted_again;
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

bool same(const WantedLayer& a, const WantedLayer& b) { return a.layer == b.layer && a.had == b.had; }

/// Written it is never longer than what it was read from.
void check_wanted_again(ByteSpan message, std::size_t written) {
  check(written == wanted.count || message.size() > kMostMessage_bytes);
  check(writer.size() <= std::min(message.size(), kMostMessage_bytes));
  check(wanted_again.count == written);
  for (std::size_t i = 0; i < written; ++i) check(same(wanted.wanted[i], wanted_again.wanted[i]));
}
std::size_t write_wanted() {
  std::size_t written = 0;
  for (const WantedLayer& each : wanted.all()) {
    for (const VersionRanges& had : each.had) check(had.highest() <= kMostVersion);
    if (!writer.add_wanted(each)) break;
    ++written;
  }
  return written;
}

bool takes_want(ByteSpan message) {
  SeenNumbers seen, seen_again;
  if (read_want(message, seen, wanted) != MessageFault::none) return false;
  writer.begin_want(seen);
  const std::size_t written = write_wanted();
  check(read_want(writer.bytes(), seen_again, wanted_again) == MessageFault::none && seen_again == seen);
  check_wanted_again(message, written);
  return true;
}

bool takes_wants(ByteSpan message) {
  // The first part's robot, or another one.
  RobotAlias robot = 0;
  if (message.size() > sizeof robot) std::copy_n(message.begin() + 1, sizeof robot, reinterpret_cast<char*>(&robot));
  std::optional<SeenNumbers> seen, seen_again;
  const MessageFault fault = read_wants(message, robot, seen, wanted);
  std::optional<SeenNumbers> no_seen;
  check(read_wants(message, ~robot, no_seen, wanted_again) == fault);
  if (fault != MessageFault::none) return false;
  check(seen.has_value() == (message.size() > 1) && (seen || wanted.count == 0));
  if (!seen) return true;
  writer.begin_wants();
  check(writer.begin_part(robot, *seen));
  const std::size_t written = write_wanted();
  check(read_wants(writer.bytes(), robot, seen_again, wanted_again) == MessageFault::none && seen_again == seen);
  check_wanted_again(message, written);
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
std::pair<std::size_t, std::size_t> write_data(const DataListener& said, std::uint16_t sequence, bool is_news) {
  if (is_news) {
    writer.begin_news(sequence);
  } else {
    writer.begin_data(sequence);
  }
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
  std::uint16_t sequence = 0, sequence_again = 0;
  DataListener said(message);
  const MessageFault fault = read_data(message, sequence, &said);
  check(read_data(message, sequence, nullptr) == fault);
  if (fault != MessageFault::none) return false;
  const auto [segments, records] =
      write_data(said, sequence, message[0] == static_cast<std::uint8_t>(MessageKind::news));
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
  for (const auto takes : {takes_beacon, takes_vector, takes_want, takes_wants, takes_data})
    taken += takes(message) ? 1 : 0;
  check(taken <= 1);
  return 0;
}
