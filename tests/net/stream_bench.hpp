// SPDX-License-Identifier: Apache-2.0
// One robot that sends layers and one that wants them, for tests: what is said between them goes by hand.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "net/outgoing_stream.hpp"

namespace g3d::tests {

inline constexpr hal::TimeNs kStreamMs = 1'000'000;

/// A record or a version by its place: robot, lane, version.
using StreamItem = std::tuple<net::RobotId, net::Lane, net::Version>;

/// Of one datagram.
struct StreamDatagram {
  std::uint16_t sequence = 0;
  mapper::Bytes bytes;
  std::vector<StreamItem> records;
  std::vector<net::DataSegment> segments;
};

/// Whose layer it is: the benches' robots have one each, and low numbers.
inline net::RobotId robot_of(net::LayerAlias alias) {
  net::RobotId robot = 1;
  while (net::alias_of(net::LayerId{robot, 1}) != alias) REQUIRE(++robot < 100);
  return robot;
}

class StreamReader final : public net::DataVisitor {
 public:
  explicit StreamReader(StreamDatagram& into) : into_(into) {}
  void on_record(const net::DataRecord& r) override {
    into_.records.emplace_back(robot_of(r.layer), r.lane, r.version);
  }
  void on_segment(const net::DataSegment& segment) override { into_.segments.push_back(segment); }

 private:
  StreamDatagram& into_;
};

/// What the receiver does with a datagram: records into the store, ranges to what is had.
class StreamTaker final : public net::DataVisitor {
 public:
  explicit StreamTaker(net::LayerStore& store) : store_(store) {}
  void on_record(const net::DataRecord& r) override {
    (void)store_.put(store_.find(r.layer), r.key, r.version, r.lane, r.payload);
  }
  void on_segment(const net::DataSegment& segment) override {
    (void)store_.add_had(store_.find(segment.layer), segment.lane, segment.range);
  }

 private:
  net::LayerStore& store_;
};

/// One who sends and one who wants; datagrams and words go by hand.
class StreamBench {
 public:
  explicit StreamBench(std::uint32_t layers = 2) {
    for (std::uint32_t l = 0; l < layers; ++l) {
      (void)ours.find_or_add({l + 1, 1});
      (void)theirs.find_or_add({l + 1, 1});
      wanted.push_back(l + 1);
    }
  }
  /// The next version of the layer, in one lane. Versions count through all lanes.
  void publish(net::RobotId robot, net::Lane lane, std::size_t bytes) {
    const net::Version version = ++versions_[robot];
    const net::LayerIndex layer = ours.find({robot, 1});
    REQUIRE(ours.put(layer, net::block_record(0, version, net::Part::whole), version, lane, mapper::Bytes(bytes, 7)) ==
            net::LayerStore::Put::stored);
    for (const net::Lane each : net::kAllLanes) REQUIRE(ours.add_had(layer, each, {0, version}));
  }
  /// They have all there will be of the lanes of a layer but the first.
  void has_other_lanes(net::RobotId robot) {
    for (const net::Lane lane : {net::Lane::frontier, net::Lane::rest}) {
      REQUIRE(theirs.add_had(theirs.find({robot, 1}), lane, {0, 1000}));
    }
  }
  bool next(StreamDatagram& datagram) {
    datagram = {};
    if (!stream.next(ours, message_, now_ns)) return false;
    datagram.bytes.assign(message_.bytes().begin(), message_.bytes().end());
    StreamReader reader(datagram);
    REQUIRE(net::read_data(datagram.bytes, datagram.sequence, &reader) == net::MessageFault::none);
    return true;
  }
  /// All that it sends without a word.
  std::vector<StreamDatagram> all_next() {
    std::vector<StreamDatagram> all;
    for (StreamDatagram datagram; next(datagram);) all.push_back(datagram);
    return all;
  }
  void take(const StreamDatagram& datagram) {
    StreamTaker taker(theirs);
    std::uint16_t sequence = 0;
    REQUIRE(net::read_data(datagram.bytes, sequence, &taker) == net::MessageFault::none);
    seen.data = std::max(seen.data, datagram.sequence);
  }
  /// The receiver's word, of where it stands now.
  void say() { stream.on_want(ours, seen, next_news, positions(), now_ns); }
  [[nodiscard]] std::vector<net::WantedLayer> positions() const {
    std::vector<net::WantedLayer> all;
    for (const net::RobotId robot : wanted) {
      net::WantedLayer& position = all.emplace_back();
      position.layer = net::alias_of(net::LayerId{robot, 1});
      const net::LayerIndex layer = theirs.find(position.layer);
      if (layer == net::kNoLayer) continue;
      for (const net::Lane lane : net::kAllLanes) {
        position.had[static_cast<std::size_t>(lane)] = theirs.had(layer, lane);
      }
    }
    return all;
  }

  net::LayerStore ours{{20, 5000, 2'000'000}}, theirs{{20, 5000, 2'000'000}};
  net::OutgoingStream stream;
  std::vector<net::RobotId> wanted;
  net::SeenNumbers seen;
  std::uint32_t next_news = 1;
  hal::TimeNs now_ns = 1000 * kStreamMs;

 private:
  net::MessageWriter message_;
  std::map<net::RobotId, net::Version> versions_;
};

/// 20 datagrams of one record each are under way.
inline std::vector<StreamDatagram> twenty_under_way(StreamBench& bench, std::size_t bytes = 1000) {
  bench.has_other_lanes(1);
  bench.say();
  std::vector<StreamDatagram> sent;
  for (int i = 0; i < 20; ++i) {
    bench.publish(1, net::Lane::ground, bytes);
    REQUIRE(bench.next(sent.emplace_back()));
  }
  REQUIRE(sent.size() == 20);
  for (const StreamDatagram& datagram : sent) REQUIRE(datagram.records.size() == 1);
  return sent;
}

inline std::set<StreamItem> versions_of_ranges(const net::LayerStore& store, net::RobotId robot) {
  std::set<StreamItem> versions;
  for (const net::Lane lane : net::kAllLanes) {
    const net::VersionRanges& had = store.had(store.find({robot, 1}), lane);
    for (net::Version v = 1; v <= had.highest(); ++v) {
      if (had.covers({v - 1, v})) versions.emplace(robot, lane, v);
    }
  }
  return versions;
}
inline void add_versions(std::multiset<StreamItem>& versions, const StreamDatagram& datagram) {
  for (const net::DataSegment& segment : datagram.segments) {
    for (net::Version v = segment.range.after + 1; v <= segment.range.upto; ++v) {
      versions.emplace(robot_of(segment.layer), segment.lane, v);
    }
  }
}

}  // namespace g3d::tests
