// SPDX-License-Identifier: Apache-2.0
#include "net/outgoing_stream.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <vector>

#include "tests/net/stream_bench.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using hal::TimeNs;
using mapper::Bytes;
using net::Lane;
using net::LayerIndex;
using net::LayerStore;
using net::OutgoingStream;
using net::Version;
using tests::add_versions;
using tests::kStreamMs;
using tests::StreamBench;
using tests::StreamDatagram;
using tests::StreamItem;
using tests::twenty_under_way;
using tests::versions_of_ranges;

TEST_CASE("all that is wanted is sent once, the ground lanes of all layers first", "[net]") {
  tests::Random random(1);
  StreamBench bench(3);
  CHECK(bench.all_next().empty());  // nobody has said a word
  for (int i = 0; i < 300; ++i) {
    const net::RobotId robot = 1 + random.below(3);
    const auto lane = static_cast<Lane>(random.below(3));
    bench.publish(robot, lane, random.below(150));
  }
  bench.say();
  std::multiset<StreamItem> records, versions;
  Lane last_lane = Lane::ground;
  std::uint16_t sequence = 0;
  for (const StreamDatagram& datagram : bench.all_next()) {
    REQUIRE(datagram.bytes.size() <= net::kMostMessage_bytes);
    REQUIRE(datagram.sequence > sequence);
    sequence = datagram.sequence;
    records.insert(datagram.records.begin(), datagram.records.end());
    add_versions(versions, datagram);
    for (const net::DataSegment& segment : datagram.segments) {
      REQUIRE(segment.lane >= last_lane);
      last_lane = segment.lane;
    }
    bench.take(datagram);
  }
  CHECK(records.size() == 300);
  CHECK(std::set<StreamItem>(records.begin(), records.end()).size() == 300);
  CHECK(std::set<StreamItem>(versions.begin(), versions.end()).size() == versions.size());
  CHECK(bench.theirs.digest() == bench.ours.digest());
  for (LayerIndex l = 0; l < 3; ++l) CHECK(bench.theirs.upto(l) == bench.ours.upto(l));
  CHECK(bench.stream.in_flight() > 0);
  bench.say();
  CHECK(bench.all_next().empty());
  CHECK(bench.stream.in_flight() == 0);
  CHECK(bench.stream.lost_segments() == 0);
}

TEST_CASE("what is in flight is not sent again, whatever words come meanwhile", "[net]") {
  StreamBench bench;
  const std::vector<StreamDatagram> sent = twenty_under_way(bench);
  for (int i = 0; i < 3; ++i) {
    bench.say();
    CHECK(bench.all_next().empty());
    bench.now_ns += 10 * kStreamMs;
  }
  CHECK(bench.stream.in_flight() == 20);
  for (std::size_t i = 0; i < 5; ++i) bench.take(sent[i]);
  bench.say();
  CHECK(bench.stream.in_flight() == 15);
  CHECK(bench.all_next().empty());
}

TEST_CASE("what lies between and behind records is told along with them, and layers come in turns", "[net]") {
  StreamBench bench(3);
  REQUIRE(bench.ours.put(0, net::status_record(1), 4, Lane::ground, {}) == LayerStore::Put::stored);
  REQUIRE(bench.ours.put(0, net::status_record(2), 7, Lane::ground, {}) == LayerStore::Put::stored);
  REQUIRE(bench.ours.add_had(0, Lane::ground, {0, 9}));
  bench.say();
  const std::vector<StreamDatagram> sparse = bench.all_next();
  REQUIRE(sparse.size() == 1);
  REQUIRE(sparse[0].segments.size() == 1);
  CHECK(sparse[0].segments[0].range == net::VersionRange{0, 9});
  CHECK(sparse[0].records.size() == 2);

  StreamBench busy(3);
  for (int i = 0; i < 30; ++i) busy.publish(static_cast<net::RobotId>(1 + i / 10), Lane::ground, 1000);
  busy.say();
  std::map<net::RobotId, int> first;
  for (int i = 0; i < 15; ++i) {
    StreamDatagram datagram;
    REQUIRE(busy.next(datagram));
    ++first[tests::robot_of(datagram.segments.at(0).layer)];
  }
  CHECK(first == std::map<net::RobotId, int>{{1, 5}, {2, 5}, {3, 5}});
}

TEST_CASE("whoever is told of a layer once is sent its news without another word", "[net]") {
  StreamBench bench;
  bench.say();
  CHECK(bench.all_next().empty());
  bench.publish(2, Lane::rest, 10);
  const std::vector<StreamDatagram> news = bench.all_next();
  REQUIRE(news.size() == 1);
  CHECK(news[0].records == std::vector<StreamItem>{{2, Lane::rest, 1}});
  CHECK(bench.all_next().empty());
  bench.publish(2, Lane::ground, 10);
  REQUIRE(bench.all_next().size() == 1);
}

TEST_CASE("a datagram that shows in no word comes again once three later ones do, and nothing else does", "[net]") {
  StreamBench bench;
  const std::vector<StreamDatagram> sent = twenty_under_way(bench);
  for (std::size_t i = 0; i < 12; ++i) {
    if (i != 4) bench.take(sent[i]);
    bench.say();
    const std::vector<StreamDatagram> again = bench.all_next();
    INFO("after datagram " << i);
    if (i != 4 + 3) {
      REQUIRE(again.empty());
      continue;
    }
    REQUIRE(again.size() == 1);
    CHECK(again[0].records == sent[4].records);
    CHECK(again[0].sequence == sent[19].sequence + 1);
    CHECK(bench.stream.lost_segments() == 1);
  }
}

TEST_CASE("without an answer one small datagram goes again at a time, with more and more patience", "[net]") {
  StreamBench bench;
  const std::vector<StreamDatagram> sent = twenty_under_way(bench, 200);
  const TimeNs begin_ns = bench.now_ns;
  std::vector<TimeNs> gaps_ns;
  TimeNs last_ns = begin_ns;
  for (; bench.now_ns < begin_ns + 30'000 * kStreamMs; bench.now_ns += kStreamMs) {
    const std::vector<StreamDatagram> again = bench.all_next();
    if (again.empty()) continue;
    REQUIRE(again.size() == 1);
    CHECK(again[0].records == sent[gaps_ns.size()].records);  // the oldest first
    gaps_ns.push_back(bench.now_ns - last_ns);
    last_ns = bench.now_ns;
  }
  REQUIRE(gaps_ns.size() > 8);
  CHECK(gaps_ns.size() < 25);
  CHECK(gaps_ns.front() > 100 * kStreamMs);
  CHECK(gaps_ns.front() < 500 * kStreamMs);
  CHECK(std::is_sorted(gaps_ns.begin(), gaps_ns.end()));
  CHECK(gaps_ns.back() <= 2001 * kStreamMs);
  CHECK(bench.stream.in_flight() == 20);
  // A word ends the silence: what is missing then comes as soon as at first.
  while (bench.all_next().empty()) bench.now_ns += kStreamMs;
  bench.say();
  const TimeNs said_ns = bench.now_ns;
  while (bench.all_next().empty()) bench.now_ns += kStreamMs;
  CHECK(bench.now_ns - said_ns < 500 * kStreamMs);
}

TEST_CASE("a word that was overtaken by a later one is ignored, but who speaks of less for long means it", "[net]") {
  StreamBench bench;
  const std::vector<StreamDatagram> sent = twenty_under_way(bench);
  const std::vector<net::WantedLayer> nothing_had = bench.positions();
  for (const StreamDatagram& datagram : sent) bench.take(datagram);
  bench.say();
  REQUIRE(bench.stream.in_flight() == 0);
  bench.now_ns += 100 * kStreamMs;
  bench.stream.on_want(bench.ours, {sent[5].sequence, 0}, 1, nothing_had, bench.now_ns);
  CHECK(bench.all_next().empty());
  bench.stream.on_want(bench.ours, {}, 1, nothing_had, bench.now_ns);
  CHECK(bench.all_next().empty());
  // It has lost its memory of us.
  bench.now_ns += 5000 * kStreamMs;
  bench.stream.on_want(bench.ours, {}, 1, nothing_had, bench.now_ns);
  CHECK(bench.all_next().size() == 20);
}

TEST_CASE("there are never more segments in flight than a number, and answers make room", "[net]") {
  StreamBench bench;
  for (int i = 0; i < 200; ++i) bench.publish(1, Lane::ground, 1000);
  bench.say();
  std::vector<StreamDatagram> sent = bench.all_next();
  CHECK(sent.size() == OutgoingStream::kMostInFlight);
  CHECK(bench.stream.in_flight() == OutgoingStream::kMostInFlight);
  for (std::size_t i = 0; i < 10; ++i) bench.take(sent[i]);
  bench.now_ns += kStreamMs;
  bench.say();
  CHECK(bench.all_next().size() == 10);
  CHECK(bench.stream.in_flight() == OutgoingStream::kMostInFlight);

  // Many segments in few datagrams are as many.
  StreamBench narrow;
  narrow.wanted = {1};
  const LayerIndex layer = narrow.ours.find({1, 1});
  for (Version v = 1; v <= 200; ++v) {
    narrow.publish(1, Lane::ground, 0);
    if (v % 2 == 0 && v < 32) REQUIRE(narrow.theirs.add_had(layer, Lane::ground, {v - 1, v}));
  }
  for (int i = 0; i < 20; ++i) {
    narrow.say();
    for (const StreamDatagram& datagram : narrow.all_next()) {
      REQUIRE(narrow.stream.in_flight() <= OutgoingStream::kMostInFlight);
      narrow.take(datagram);
    }
  }
  CHECK(narrow.theirs.upto(layer) == narrow.ours.upto(layer));
}

TEST_CASE("what a word does not name any more is not sent, and what we do not have is passed over", "[net]") {
  StreamBench bench(2);
  bench.wanted = {77, 1, 2};
  bench.has_other_lanes(1);
  bench.has_other_lanes(2);
  for (int i = 0; i < 4; ++i) bench.publish(static_cast<net::RobotId>(1 + i % 2), Lane::ground, 1000);
  bench.say();
  CHECK(bench.all_next().size() == 4);
  bench.wanted = {2, 77};
  bench.say();
  CHECK(bench.stream.in_flight() == 2);
  bench.publish(1, Lane::ground, 10);
  CHECK(bench.all_next().empty());
  bench.publish(2, Lane::ground, 10);
  REQUIRE(bench.all_next().size() == 1);
  bench.wanted = {};
  bench.say();
  CHECK(bench.stream.in_flight() == 0);
  bench.now_ns += 60'000 * kStreamMs;
  CHECK(bench.all_next().empty());
}

TEST_CASE("who has started anew is sent nothing before its first word, and then all", "[net]") {
  StreamBench bench;
  (void)twenty_under_way(bench);
  bench.stream.clear();
  CHECK(bench.stream.in_flight() == 0);
  bench.now_ns += 60'000 * kStreamMs;
  CHECK(bench.all_next().empty());
  bench.say();
  CHECK(bench.all_next().size() == 20);
}

TEST_CASE("the time that an answer takes is learned", "[net]") {
  StreamBench bench;
  for (int i = 0; i < 40; ++i) {
    bench.publish(1, Lane::ground, 10);
    bench.say();
    const std::vector<StreamDatagram> sent = bench.all_next();
    REQUIRE(sent.size() == 1);
    bench.take(sent[0]);
    bench.now_ns += 900 * kStreamMs;
    bench.say();
  }
  CHECK(bench.stream.answer_time_ns() > 850 * kStreamMs);
  CHECK(bench.stream.answer_time_ns() <= 900 * kStreamMs);
}

TEST_CASE("of what we have, gaps or not, exactly that is sent which they lack, gaps or not", "[net]") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    tests::Random random(seed);
    StreamBench bench(1);
    std::set<StreamItem> records;  // of ours; theirs has ranges alone, as if all in them were superseded
    for (Version v = 1; v <= 120; ++v) {
      const auto lane = static_cast<Lane>(random.below(3));
      REQUIRE(bench.ours.put(0, net::block_record(0, v, net::Part::whole), v, lane, Bytes(random.below(300), 1)) ==
              LayerStore::Put::stored);
      records.emplace(1, lane, v);
    }
    for (const Lane lane : net::kAllLanes) {
      for (int i = 0; i < 12; ++i) {
        const Version ours = random.below(110), theirs = random.below(115);
        (void)bench.ours.add_had(0, lane, {ours, ours + random.below(12)});
        (void)bench.theirs.add_had(0, lane, {theirs, theirs + random.below(6)});
      }
    }
    std::set<StreamItem> lacking;
    const std::set<StreamItem> theirs = versions_of_ranges(bench.theirs, 1);
    for (const StreamItem& item : versions_of_ranges(bench.ours, 1)) {
      if (!theirs.contains(item)) lacking.insert(item);
    }
    bench.say();
    std::multiset<StreamItem> sent_versions;
    std::vector<StreamItem> sent_records;
    for (const StreamDatagram& datagram : bench.all_next()) {
      add_versions(sent_versions, datagram);
      sent_records.insert(sent_records.end(), datagram.records.begin(), datagram.records.end());
    }
    REQUIRE(bench.stream.in_flight() < OutgoingStream::kMostInFlight);
    REQUIRE(std::equal(sent_versions.begin(), sent_versions.end(), lacking.begin(), lacking.end()));
    std::set<StreamItem> expected;
    for (const StreamItem& item : lacking) {
      if (records.contains(item)) expected.insert(item);
    }
    std::sort(sent_records.begin(), sent_records.end());
    REQUIRE(std::equal(sent_records.begin(), sent_records.end(), expected.begin(), expected.end()));
  }
}

TEST_CASE("a hostile want that names one layer many times gets it once", "[net]") {
  StreamBench bench(1);
  for (int i = 0; i < 150; ++i) bench.publish(1, static_cast<Lane>(i % 3), 200);
  tests::Random random(5);
  for (int i = 1; i < 70; ++i) bench.wanted.push_back(1);
  std::vector<net::WantedLayer> positions = bench.positions();
  bench.stream.on_want(bench.ours, {}, 1, positions, bench.now_ns);
  std::multiset<StreamItem> records;
  for (const StreamDatagram& datagram : bench.all_next())
    records.insert(datagram.records.begin(), datagram.records.end());
  CHECK(records.size() == 150);
  // With other ranges every time it may get some again, but never more than the number in flight.
  for (net::WantedLayer& position : positions) {
    for (net::VersionRanges& had : position.had) {
      for (int r = 0; r < 16; ++r) {
        const Version after = random.below(140);
        (void)had.add({after, after + 1 + random.below(4)});
      }
    }
  }
  for (int i = 0; i < 10; ++i) {
    bench.now_ns += 10 * kStreamMs;
    bench.stream.on_want(bench.ours, {}, 1, positions, bench.now_ns);
    CHECK(bench.all_next().size() <= OutgoingStream::kMostInFlight);
    REQUIRE(bench.stream.in_flight() <= OutgoingStream::kMostInFlight);
  }
}

TEST_CASE("over a bad link all arrives in the end, and little of it twice", "[net]") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    INFO("seed " << seed);
    tests::Random random(seed);
    StreamBench bench(2);
    struct Word {
      net::SeenNumbers seen;
      std::vector<net::WantedLayer> positions;
    };
    std::multimap<TimeNs, StreamDatagram> datagrams;
    std::multimap<TimeNs, Word> words;
    const std::uint32_t lost_percent = seed % 2 == 0 ? 25 : 5;
    const auto arrival = [&] { return bench.now_ns + (5 + random.below(random.below(10) == 0 ? 40 : 4)) * kStreamMs; };
    std::size_t published = 0, sent = 0;
    TimeNs word_ns = 0, took_ns = 0;
    const TimeNs begin_ns = bench.now_ns;
    for (; bench.now_ns < begin_ns + 60'000 * kStreamMs; bench.now_ns += kStreamMs) {
      if (published < 1500) {
        const net::RobotId robot = 1 + random.below(2);
        const auto lane = static_cast<Lane>(random.below(3));
        bench.publish(robot, lane, random.below(400));
        ++published;
      }
      for (; !words.empty() && words.begin()->first <= bench.now_ns; words.erase(words.begin())) {
        bench.stream.on_want(bench.ours, words.begin()->second.seen, 1, words.begin()->second.positions, bench.now_ns);
      }
      if (StreamDatagram datagram; bench.next(datagram)) {
        sent += datagram.records.size();
        if (random.below(100) >= lost_percent) datagrams.emplace(arrival(), datagram);
      }
      for (; !datagrams.empty() && datagrams.begin()->first <= bench.now_ns; datagrams.erase(datagrams.begin())) {
        bench.take(datagrams.begin()->second);
        if (took_ns < word_ns) took_ns = bench.now_ns;
      }
      const bool is_due = took_ns >= word_ns && bench.now_ns - took_ns >= 10 * kStreamMs;
      if (is_due || bench.now_ns - word_ns >= 250 * kStreamMs) {
        word_ns = bench.now_ns + 1;
        if (random.below(100) >= lost_percent) words.emplace(arrival(), Word{bench.seen, bench.positions()});
      }
      if (published == 1500 && bench.theirs.digest() == bench.ours.digest()) break;
    }
    INFO("after " << (bench.now_ns - begin_ns) / kStreamMs << " ms, " << sent << " of " << published);
    REQUIRE(bench.theirs.digest() == bench.ours.digest());
    CHECK(static_cast<double>(sent) < static_cast<double>(published) * (lost_percent > 10 ? 1.6 : 1.25));
  }
}
