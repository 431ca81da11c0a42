// SPDX-License-Identifier: Apache-2.0
// Messages between robots for tests: random ones, what they say in a form that can be compared, and hostile ones read.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "net/sync_message.hpp"
#include "tests/support/sample_maps.hpp"

namespace g3d::tests {

/// What a data message says, to compare.
struct SaidRecord {
  net::LayerAlias layer = 0;
  net::Lane lane = net::Lane::rest;
  net::RecordKey key = 0;
  net::Version version = 0;
  mapper::Bytes payload;
  bool operator==(const SaidRecord&) const = default;
};
struct SaidSegment {
  net::LayerAlias layer = 0;
  net::Lane lane = net::Lane::rest;
  net::VersionRange range;
  std::vector<SaidRecord> records;
  bool operator==(const SaidSegment&) const = default;
};
class SaidData final : public net::DataVisitor {
 public:
  explicit SaidData(mapper::ByteSpan message) : message_(message) {}
  void on_record(const net::DataRecord& record) override {
    // A payload lies in the message.
    REQUIRE((record.payload.empty() ||
             (record.payload.data() >= message_.data() &&
              record.payload.data() + record.payload.size() <= message_.data() + message_.size())));
    REQUIRE(record.payload.size() <= net::kMostPayload_bytes);
    REQUIRE(net::is_record_key(record.key));
    REQUIRE(record.version <= net::kMostVersion);
    REQUIRE(static_cast<int>(record.lane) < net::kLanes);
    REQUIRE((open_.empty() || record.version > open_.back().version));
    open_.push_back(
        {record.layer, record.lane, record.key, record.version, {record.payload.begin(), record.payload.end()}});
  }
  void on_segment(const net::DataSegment& segment) override {
    REQUIRE(segment.range.after <= segment.range.upto);
    REQUIRE(segment.range.upto <= net::kMostVersion);
    for (const SaidRecord& record : open_) {
      REQUIRE(record.layer == segment.layer);
      REQUIRE(record.lane == segment.lane);
      REQUIRE(record.version > segment.range.after);
      REQUIRE(record.version <= segment.range.upto);
    }
    segments.push_back({segment.layer, segment.lane, segment.range, std::move(open_)});
    open_.clear();
  }
  std::vector<SaidSegment> segments;

 private:
  mapper::ByteSpan message_;
  std::vector<SaidRecord> open_;
};

inline net::Version random_wire_version(Random& random) { return random.next() >> (16 + random.below(48)); }
inline net::LayerId random_layer_id(Random& random) {
  return {random.next(), static_cast<std::uint32_t>(random.next())};
}
inline net::RecordKey random_wire_key(Random& random) {
  switch (random.below(4)) {
    case 0:
      return net::pose_record(random.below(net::kMaxSubmaps));
    case 1:
      return net::status_record(random.below(20));
    default:
      break;
  }
  const std::uint32_t submap = random.below(net::kMaxSubmaps);
  const mapper::BlockKey block = random.next() & ((1ULL << 39) - 1);
  return net::block_record(submap, block, static_cast<net::Part>(random.below(3)));
}
inline net::LayerVersions random_layer_versions(Random& random) {
  net::LayerVersions layer{random_layer_id(random), {}, random_wire_version(random), random.next()};
  for (net::Version& upto : layer.upto) upto = layer.highest - std::min(layer.highest, random_wire_version(random));
  return layer;
}
inline net::LayerAlias random_layer_alias(Random& random) { return static_cast<net::LayerAlias>(random.next()); }
inline net::WantedLayer random_wanted_layer(Random& random) {
  net::WantedLayer wanted{random_layer_alias(random), {}};
  for (net::VersionRanges& had : wanted.had) {
    had = net::VersionRanges(random_wire_version(random));
    const std::uint32_t beyond = random.below(net::VersionRanges::kMostBeyond + 1);
    for (std::uint32_t i = 0; i < beyond; ++i) {
      const net::Version after = had.highest() + 1 + random_wire_version(random) / 64;
      const net::Version upto = after + 1 + random_wire_version(random) / 64;
      if (upto <= net::kMostVersion) REQUIRE(had.add({after, upto}));
    }
  }
  return wanted;
}
/// Segments of random records until the message is full; what it was told.
inline std::vector<SaidSegment> fill_with_data(Random& random, net::MessageWriter& message,
                                               std::uint32_t most_payload) {
  std::vector<SaidSegment> said;
  const auto sequence = static_cast<std::uint16_t>(random.next());
  if (random.below(2) == 0) {
    message.begin_data(sequence);
  } else {
    message.begin_news(sequence);
  }
  for (net::LayerAlias layer = random_layer_alias(random);;) {
    if (random.below(2) == 0) layer = random_layer_alias(random);
    const auto lane = static_cast<net::Lane>(random.below(net::kLanes));
    const net::Version after = random_wire_version(random) / 2;
    if (!message.begin_segment(layer, lane, after, most_payload)) return said;
    SaidSegment segment{layer, lane, {after, after}, {}};
    for (std::uint32_t i = random.below(6); i > 0; --i) {
      const net::Version version =
          segment.range.upto + 1 + (random.below(2) == 0 ? 0 : random_wire_version(random) / 64);
      const net::RecordKey key = random_wire_key(random);
      const std::uint32_t bytes = random.below(most_payload + 1);
      const mapper::Bytes payload(bytes, static_cast<std::uint8_t>(random.next()));
      const auto place = message.add_record(key, version, payload.size());
      if (!place) break;
      REQUIRE(place->size() == payload.size());
      std::copy(payload.begin(), payload.end(), place->begin());
      segment.range.upto = version;
      segment.records.push_back({layer, lane, key, version, payload});
    }
    segment.range.upto += random.below(3);
    message.end_segment(segment.range.upto);
    said.push_back(segment);
  }
}

/// Exactly as long as the message, so that a sanitizer sees every read outside.
class ExactMessage {
 public:
  explicit ExactMessage(mapper::ByteSpan bytes) : memory_(new std::uint8_t[bytes.size()]), size_(bytes.size()) {
    std::copy(bytes.begin(), bytes.end(), memory_.get());
  }
  [[nodiscard]] mapper::ByteSpan bytes() const { return {memory_.get(), size_}; }
  [[nodiscard]] std::span<std::uint8_t> writable() { return {memory_.get(), size_}; }

 private:
  std::unique_ptr<std::uint8_t[]> memory_;
  std::size_t size_;
};

inline void check_layers_are_possible(const net::LayerList& layers) {
  REQUIRE(layers.count <= net::kMostLayersInMessage);
  for (const net::LayerVersions& layer : layers.all()) {
    REQUIRE(layer.highest <= net::kMostVersion);
    for (const net::Version upto : layer.upto) REQUIRE(upto <= layer.highest);
  }
}

inline void check_wanted_is_possible(const net::WantedList& list) {
  REQUIRE(list.count <= net::kMostWantedInMessage);
  for (const net::WantedLayer& wanted : list.all()) {
    for (const net::VersionRanges& had : wanted.had) REQUIRE(had.highest() <= net::kMostVersion);
  }
}

/// Whose part of wants is read.
inline constexpr net::RobotAlias kSampleRobot = 77;

/// Through the reader of its kind: a fault, or something that can be.
inline net::MessageFault fault_of_any(mapper::ByteSpan message) {
  std::uint64_t digest = 0;
  std::uint16_t number = 0;
  bool wants_answer = false;
  net::LayerList layers;
  const auto wanted = std::make_unique<net::WantedList>();
  net::SeenNumbers seen;
  std::optional<net::SeenNumbers> seen_part;
  net::MessageFault fault = net::read_beacon(message, digest, layers);
  if (fault == net::MessageFault::none) check_layers_are_possible(layers);
  if (fault != net::MessageFault::unknown_kind) return fault;
  fault = net::read_vector(message, wants_answer, layers);
  if (fault == net::MessageFault::none) check_layers_are_possible(layers);
  if (fault != net::MessageFault::unknown_kind) return fault;
  fault = net::read_want(message, seen, *wanted);
  if (fault == net::MessageFault::none) check_wanted_is_possible(*wanted);
  if (fault != net::MessageFault::unknown_kind) return fault;
  fault = net::read_wants(message, kSampleRobot, seen_part, *wanted);
  if (fault == net::MessageFault::none) check_wanted_is_possible(*wanted);
  if (fault != net::MessageFault::unknown_kind) return fault;
  SaidData said(message);
  fault = net::read_data(message, number, &said);
  REQUIRE(net::read_data(message, number, nullptr) == fault);
  return fault;
}

}  // namespace g3d::tests
