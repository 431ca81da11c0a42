// SPDX-License-Identifier: Apache-2.0
#include "net/sync_message.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "tests/net/sync_message_samples.hpp"

using namespace g3d;
using mapper::Bytes;
using mapper::ByteSpan;
using net::Lane;
using net::LayerVersions;
using net::MessageFault;
using net::MessageWriter;
using net::RecordKey;
using net::SeenNumbers;
using net::Version;
using net::WantedLayer;
using tests::ExactMessage;
using tests::fault_of_any;
using tests::fill_with_data;
using tests::random_layer_versions;
using tests::random_wanted_layer;
using tests::SaidData;
using tests::SaidSegment;

namespace {

bool same_layer_versions(const LayerVersions& a, const LayerVersions& b, bool with_hash) {
  return a.id == b.id && a.upto == b.upto && a.highest == b.highest && (!with_hash || a.content_hash == b.content_hash);
}
bool same_wanted(const WantedLayer& a, const WantedLayer& b) { return a.layer == b.layer && a.had == b.had; }

/// One of each kind, of medium length.
std::vector<Bytes> messages_of_all_kinds(tests::Random& random) {
  std::vector<Bytes> all;
  MessageWriter message;
  const auto keep = [&] { all.emplace_back(message.bytes().begin(), message.bytes().end()); };
  message.begin_beacon(random.next());
  for (int i = 0; i < 5; ++i) REQUIRE(message.add_layer(random_layer_versions(random)));
  keep();
  message.begin_vector(true);
  for (int i = 0; i < 5; ++i) REQUIRE(message.add_layer(random_layer_versions(random)));
  keep();
  message.begin_want({3, 4});
  (void)message.add_wanted(random_wanted_layer(random));
  (void)message.add_wanted(random_wanted_layer(random));
  keep();
  message.begin_wants();
  for (const net::RobotAlias robot : {tests::kSampleRobot, tests::kSampleRobot + 1}) {
    REQUIRE(message.begin_part(robot, {5, 6}));
    (void)message.add_wanted(random_wanted_layer(random));
  }
  keep();
  (void)fill_with_data(random, message, 40);
  keep();
  return all;
}

Bytes bytes_of(const MessageWriter& message) { return {message.bytes().begin(), message.bytes().end()}; }

MessageFault data_fault(const Bytes& segments) {
  Bytes message{4, 1, 0};
  mapper::put_bytes(message, segments);
  return fault_of_any(ExactMessage(message).bytes());
}
/// A head of a new layer's segment.
Bytes segment_of_ground(std::initializer_list<std::uint8_t> rest) {
  Bytes segment(5, 0);
  segment.insert(segment.end(), rest);
  return segment;
}

}  // namespace

TEST_CASE("beacons and vectors are filled to the brim, and say what was written into them", "[net]") {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    INFO("seed " << seed);
    tests::Random random(seed);
    MessageWriter message;
    const bool is_vector = seed % 2 == 0, wants = seed % 4 == 0;
    const std::uint64_t digest = random.next();
    if (is_vector) {
      message.begin_vector(wants);
    } else {
      message.begin_beacon(digest);
    }
    std::vector<LayerVersions> told;
    const std::size_t most = seed % 3 == 0 ? random.below(10) : 1000;
    for (LayerVersions layer = random_layer_versions(random); told.size() < most;
         layer = random_layer_versions(random)) {
      if (seed % 5 == 0) layer = {layer.id, {}, 0, layer.content_hash};  // as short as they get
      const Bytes before = bytes_of(message);
      if (!message.add_layer(layer)) {
        REQUIRE(bytes_of(message) == before);
        REQUIRE(message.size() > net::kMostMessage_bytes - 60);
        break;
      }
      REQUIRE(message.size() <= net::kMostMessage_bytes);
      told.push_back(layer);
    }
    const ExactMessage exact(message.bytes());
    net::LayerList layers;
    std::uint64_t read_digest = 0;
    bool read_wants = !wants;
    REQUIRE((is_vector ? net::read_vector(exact.bytes(), read_wants, layers)
                       : net::read_beacon(exact.bytes(), read_digest, layers)) == MessageFault::none);
    CHECK((is_vector ? read_wants == wants : read_digest == digest));
    REQUIRE(std::equal(told.begin(), told.end(), layers.all().begin(), layers.all().end(),
                       [&](const auto& a, const auto& b) { return same_layer_versions(a, b, is_vector); }));
  }
}

TEST_CASE("wants are filled to the brim, and say what was written into them", "[net]") {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    INFO("seed " << seed);
    tests::Random random(seed);
    MessageWriter message;
    const SeenNumbers seen{static_cast<std::uint16_t>(random.next()), static_cast<std::uint16_t>(random.next())};
    message.begin_want(seen);
    std::vector<WantedLayer> told;
    for (;;) {
      WantedLayer wanted = random_wanted_layer(random);
      if (seed % 3 == 0) wanted.had = {};  // as short as they get
      const Bytes before = bytes_of(message);
      const bool is_told = message.add_wanted(wanted);
      REQUIRE(message.size() <= net::kMostMessage_bytes);
      if (!is_told) REQUIRE(bytes_of(message) == before);
      if (!is_told) break;
      told.push_back(wanted);
    }
    REQUIRE(told.size() >= 1);
    const ExactMessage exact(message.bytes());
    const auto wanted = std::make_unique<net::WantedList>();
    SeenNumbers read_seen;
    REQUIRE(net::read_want(exact.bytes(), read_seen, *wanted) == MessageFault::none);
    CHECK(read_seen == seen);
    REQUIRE(std::equal(told.begin(), told.end(), wanted->all().begin(), wanted->all().end(), same_wanted));
  }
}

TEST_CASE("of wants for many everybody reads its own part, and nothing if there is none", "[net]") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    tests::Random random(seed);
    MessageWriter message;
    message.begin_wants();
    std::vector<std::pair<SeenNumbers, std::vector<WantedLayer>>> told;
    for (net::RobotAlias robot = 1;; ++robot) {
      const SeenNumbers seen{static_cast<std::uint16_t>(random.next()), static_cast<std::uint16_t>(random.next())};
      const Bytes before = bytes_of(message);
      if (!message.begin_part(robot, seen)) {
        REQUIRE(bytes_of(message) == before);
        break;
      }
      told.emplace_back(seen, std::vector<WantedLayer>{});
      for (std::uint32_t i = seed % 4 == 0 ? 200 : random.below(4); i > 0; --i) {
        WantedLayer wanted = random_wanted_layer(random);
        if (seed % 2 == 0) wanted.had = {};
        if (!message.add_wanted(wanted)) break;
        told.back().second.push_back(wanted);
      }
      REQUIRE(message.size() <= net::kMostMessage_bytes);
      if (seed % 10 == 1 && robot == 3) {
        message.cut(before.size());  // as if it had not fitted
        told.pop_back();
        break;
      }
    }
    const ExactMessage exact(message.bytes());
    const auto wanted = std::make_unique<net::WantedList>();
    std::optional<SeenNumbers> seen;
    for (net::RobotAlias robot = 1; robot <= told.size(); ++robot) {
      REQUIRE(net::read_wants(exact.bytes(), robot, seen, *wanted) == MessageFault::none);
      REQUIRE(seen == told[robot - 1].first);
      const std::vector<WantedLayer>& its = told[robot - 1].second;
      REQUIRE(std::equal(its.begin(), its.end(), wanted->all().begin(), wanted->all().end(), same_wanted));
    }
    REQUIRE(net::read_wants(exact.bytes(), 0, seen, *wanted) == MessageFault::none);
    CHECK_FALSE(seen);
    CHECK(wanted->count == 0);
  }
}

TEST_CASE("data messages are filled to the brim, and say what was written into them", "[net]") {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    INFO("seed " << seed);
    tests::Random random(seed);
    MessageWriter message;
    const std::vector<SaidSegment> told = fill_with_data(random, message, 1 + random.below(400));
    REQUIRE(message.size() <= net::kMostMessage_bytes);
    REQUIRE_FALSE(told.empty());
    const ExactMessage exact(message.bytes());
    SaidData said(exact.bytes());
    std::uint16_t sequence = 0;
    REQUIRE(net::read_data(exact.bytes(), sequence, &said) == MessageFault::none);
    REQUIRE(said.segments == told);
  }
}

TEST_CASE("the longest record fits a datagram of its own, whatever its numbers are", "[net]") {
  MessageWriter message;
  const RecordKey highest_key = net::status_record(0xFFFFFFFFU);
  for (const Version version : {Version{1}, net::kMostVersion}) {
    for (const Version after : {Version{0}, version - 1}) {
      message.begin_data(0xFFFFU);
      REQUIRE(message.begin_segment(~0U, Lane::rest, after, net::kMostPayload_bytes));
      const auto place = message.add_record(highest_key, version, net::kMostPayload_bytes);
      REQUIRE(place);
      std::fill(place->begin(), place->end(), std::uint8_t{0xEE});
      message.end_segment(net::kMostVersion);
      REQUIRE(message.size() <= net::kMostMessage_bytes);
      const ExactMessage exact(message.bytes());
      SaidData said(exact.bytes());
      std::uint16_t sequence = 0;
      REQUIRE(net::read_data(exact.bytes(), sequence, &said) == MessageFault::none);
      REQUIRE(said.segments.size() == 1);
      const net::LayerAlias id = ~0U;
      const Bytes payload(net::kMostPayload_bytes, 0xEE);
      CHECK(said.segments[0] ==
            SaidSegment{id, Lane::rest, {after, net::kMostVersion}, {{id, Lane::rest, highest_key, version, payload}}});
      CHECK_FALSE(message.begin_segment(1, Lane::ground, 0, 50));
    }
  }
}

TEST_CASE("a message that is cut off anywhere gives a fault, or what came before the cut", "[net][long]") {
  tests::Random random(21);
  for (int round = 0; round < 3; ++round) {
    for (const Bytes& whole : messages_of_all_kinds(random)) {
      REQUIRE(fault_of_any(whole) == MessageFault::none);
      int valid = 0;
      for (std::size_t size = 0; size < whole.size(); ++size) {
        const MessageFault fault = fault_of_any(ExactMessage(ByteSpan(whole).first(size)).bytes());
        REQUIRE((fault == MessageFault::none || fault == MessageFault::truncated));
        if (fault == MessageFault::none) ++valid;
      }
      CHECK(valid <= 40);  // between layers, positions or segments
    }
  }
}

TEST_CASE("bytes changed by a hostile hand give a fault or a message that can be", "[net]") {
  tests::Random random(22);
  std::array<int, net::kMessageFaults> faults{};
  for (int round = 0; round < 200; ++round) {
    for (const Bytes& whole : messages_of_all_kinds(random)) {
      ExactMessage changed(whole);
      for (std::uint32_t i = 1 + random.below(4); i > 0; --i) {
        std::uint8_t& byte = changed.writable()[random.below(static_cast<std::uint32_t>(whole.size()))];
        constexpr std::uint8_t kNasty[] = {0, 1, 0x7F, 0x80, 0xFF};
        byte = random.below(2) == 0 ? kNasty[random.below(5)] : static_cast<std::uint8_t>(random.next());
      }
      ++faults[static_cast<std::size_t>(fault_of_any(changed.bytes()))];
    }
  }
  for (const MessageFault fault :
       {MessageFault::none, MessageFault::truncated, MessageFault::bad_range, MessageFault::bad_record}) {
    CHECK(faults[static_cast<std::size_t>(fault)] > 10);
  }
}

TEST_CASE("every fault of a message is told by its name", "[net]") {
  CHECK(fault_of_any({}) == MessageFault::truncated);
  CHECK(fault_of_any(Bytes{0}) == MessageFault::unknown_kind);
  CHECK(fault_of_any(Bytes{5, 0, 0, 0, 0, 0, 0, 0, 0}) == MessageFault::unknown_kind);
  CHECK(data_fault({}) == MessageFault::none);
  CHECK(data_fault(segment_of_ground({0, 0, 0})) == MessageFault::none);
  CHECK(data_fault(segment_of_ground({0, 0})) == MessageFault::truncated);
  CHECK(data_fault({3}) == MessageFault::bad_record);                              // no such lane
  CHECK(data_fault({8}) == MessageFault::bad_record);                              // no such flag
  CHECK(data_fault({4, 0}) == MessageFault::bad_record);                           // the same layer as none
  CHECK(data_fault(segment_of_ground({0, 3, 4, 9, 0, 0})) == MessageFault::none);  // a record of one byte
  CHECK(data_fault(segment_of_ground({0, 1, 3, 3, 4, 9, 0, 0})) == MessageFault::none);
  CHECK(data_fault(segment_of_ground({0, 1, 3, 0, 0})) == MessageFault::bad_record);        // left out, but no record
  CHECK(data_fault(segment_of_ground({0, 1, 3, 1, 3, 3, 4})) == MessageFault::bad_record);  // left out twice
  CHECK(data_fault(segment_of_ground({0, 3, 6, 9, 0, 0})) == MessageFault::bad_record);     // key 3: no such part
  CHECK(data_fault(segment_of_ground({0, 3, 1, 9, 0, 0})) == MessageFault::bad_record);     // key -1
  CHECK(data_fault(segment_of_ground({0, 3, 4})) == MessageFault::truncated);               // its byte is missing
  Bytes longest = segment_of_ground({0, 0xC4, 8, 4});                                       // 1090 bytes
  longest.resize(longest.size() + net::kMostPayload_bytes + 2, 0);
  CHECK(data_fault(longest) == MessageFault::none);
  longest[6] += 1;
  longest.push_back(0);
  CHECK(data_fault(longest) == MessageFault::bad_record);
  // 2^48 is the last version, 2^48 + 1 is none.
  CHECK(data_fault(segment_of_ground({0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x40, 0, 0})) == MessageFault::none);
  CHECK(data_fault(segment_of_ground({0x81, 0x80, 0x80, 0x80, 0x80, 0x80, 0x40, 0, 0})) == MessageFault::bad_range);
  CHECK(data_fault(segment_of_ground({0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x40, 0, 1})) == MessageFault::bad_range);
  CHECK(data_fault(segment_of_ground({0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x40, 2, 0})) == MessageFault::bad_range);
  // The longest number that can be read; a longer one is none.
  const std::initializer_list<std::uint8_t> most{0, 1, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F, 2, 0};
  CHECK(data_fault(segment_of_ground(most)) == MessageFault::bad_range);
  const std::initializer_list<std::uint8_t> more{0, 0, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0};
  CHECK(data_fault(segment_of_ground(more)) == MessageFault::truncated);
}

TEST_CASE("a layer that claims more than there is, or less than nothing, is refused", "[net]") {
  const auto fault = [](std::initializer_list<std::uint8_t> numbers) {
    Bytes beacon(9 + 12, 0);
    beacon[0] = 1;
    beacon.insert(beacon.end(), numbers);
    return fault_of_any(ExactMessage(beacon).bytes());
  };
  CHECK(fault({5, 5, 0, 4}) == MessageFault::none);
  CHECK(fault({5, 6, 0, 4}) == MessageFault::bad_range);
  CHECK(fault({5, 5, 0, 6}) == MessageFault::bad_range);
  CHECK(fault({5, 5, 0}) == MessageFault::truncated);
  CHECK(fault({0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x40, 0, 0, 0}) == MessageFault::none);
  CHECK(fault({0x81, 0x80, 0x80, 0x80, 0x80, 0x80, 0x40, 0, 0, 0}) == MessageFault::bad_range);
  // Lists keep what they were told last: a beacon knows no hashes, whatever a vector said before.
  net::LayerList layers;
  std::uint64_t digest = 0;
  bool wants = false;
  Bytes vector(2 + 24, 0xFF);
  vector[0] = 2;
  std::fill(vector.begin() + 14, vector.begin() + 18, std::uint8_t{0});
  REQUIRE(net::read_vector(vector, wants, layers) == MessageFault::none);
  REQUIRE(layers.layers[0].content_hash == ~0ULL);
  Bytes beacon(9 + 16, 0);
  beacon[0] = 1;
  REQUIRE(net::read_beacon(beacon, digest, layers) == MessageFault::none);
  CHECK(layers.layers[0].content_hash == 0);
}

TEST_CASE("more layers, positions or ranges than a datagram can hold are refused", "[net]") {
  Bytes beacon(9, 0), vector{2, 0}, want{3, 0, 0, 0, 0};
  beacon[0] = 1;
  beacon.resize(beacon.size() + net::kMostLayersInMessage * 16, 0);
  vector.resize(vector.size() + net::kMostLayersInMessage * 24, 0);
  want.resize(want.size() + net::kMostWantedInMessage * 8, 0);
  for (Bytes message : {beacon, vector, want}) {
    CHECK(fault_of_any(message) == MessageFault::none);
    message.resize(message.size() + 24, 0);
    CHECK(fault_of_any(message) == MessageFault::too_many);
  }
  Bytes ranges{3, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, net::VersionRanges::kMostBeyond};
  ranges.resize(ranges.size() + 2 * net::VersionRanges::kMostBeyond, 1);
  CHECK(fault_of_any(ranges) == MessageFault::none);
  ranges[13] += 1;
  CHECK(fault_of_any(ranges) == MessageFault::too_many);
  ranges[13] -= 1;
  ranges[16] = 0;  // a range that touches what is before it
  CHECK(fault_of_any(ranges) == MessageFault::bad_range);
  Bytes part{7, 1, 0, 0, 0, 0, 0, 0, 0, 128};
  CHECK(fault_of_any(part) == MessageFault::too_many);
  part[9] = 1;
  CHECK(fault_of_any(part) == MessageFault::truncated);
}
