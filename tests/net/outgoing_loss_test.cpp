// SPDX-License-Identifier: Apache-2.0
// How an OutgoingStream finds out what was lost, alone and of what went to all.
#include <catch2/catch.hpp>
#include <vector>

#include "net/outgoing_stream.hpp"
#include "tests/net/stream_bench.hpp"

using namespace g3d;
using net::Lane;
using net::LayerStore;
using net::Version;
using tests::kStreamMs;
using tests::StreamBench;
using tests::StreamDatagram;
using tests::StreamItem;
using tests::twenty_under_way;

TEST_CASE("without an answer a word is asked for by an empty datagram, and the word tells all that is lost", "[net]") {
  StreamBench bench;
  const std::vector<StreamDatagram> sent = twenty_under_way(bench);
  StreamDatagram ask;
  while (!bench.next(ask)) bench.now_ns += kStreamMs;
  CHECK(ask.segments.empty());
  CHECK(ask.bytes.size() == 3);
  CHECK(ask.sequence == sent.back().sequence + 1);
  CHECK(bench.stream.in_flight() == 20);
  CHECK(bench.all_next().empty());
  for (std::size_t i = 0; i < 20; ++i) {
    if (i != 4 && i != 19) bench.take(sent[i]);
  }
  bench.take(ask);
  bench.say();
  std::vector<StreamItem> again;
  for (const StreamDatagram& datagram : bench.all_next()) {
    again.insert(again.end(), datagram.records.begin(), datagram.records.end());
  }
  CHECK(again == std::vector<StreamItem>{sent[4].records[0], sent[19].records[0]});
}

TEST_CASE("a word that comes late enough tells of one datagram that a later one has overtaken", "[net]") {
  StreamBench bench;
  const std::vector<StreamDatagram> sent = twenty_under_way(bench);
  for (std::size_t i = 0; i < 20; ++i) {
    if (i != 18) bench.take(sent[i]);
  }
  bench.now_ns += 90 * kStreamMs;
  bench.say();
  CHECK(bench.all_next().empty());
  bench.now_ns += 20 * kStreamMs;
  bench.say();
  const std::vector<StreamDatagram> again = bench.all_next();
  REQUIRE(again.size() == 1);
  CHECK(again[0].records == sent[18].records);
}

TEST_CASE("what goes to all is under way to whoever wants it, and comes again alone to who has missed it", "[net]") {
  StreamBench bench;
  bench.has_other_lanes(1);
  bench.say();
  for (int i = 0; i < 5; ++i) bench.publish(1, Lane::ground, 300);
  const std::size_t place = bench.stream.wanted_layer(0) == 0 ? 0 : 1;
  CHECK(bench.stream.next_gap(bench.ours, place, Lane::ground) == net::VersionRange{0, 5});
  CHECK(bench.stream.lacks(bench.ours, place));
  bench.stream.note_news(1, place, Lane::ground, {0, 3}, 900, bench.now_ns);
  bench.stream.note_news(2, place, Lane::ground, {3, 5}, 600, bench.now_ns);
  bench.next_news = 3;
  CHECK(bench.all_next().empty());
  CHECK(bench.stream.lacks(bench.ours, place));
  REQUIRE(bench.theirs.add_had(0, Lane::ground, {3, 5}));
  bench.now_ns += 110 * kStreamMs;
  bench.seen.news = 2;
  bench.say();
  const std::vector<StreamDatagram> again = bench.all_next();
  REQUIRE(again.size() == 1);
  REQUIRE(again[0].segments.size() == 1);
  CHECK(again[0].segments[0].range == net::VersionRange{0, 3});
  bench.take(again[0]);
  bench.say();
  CHECK_FALSE(bench.stream.lacks(bench.ours, place));
  CHECK(bench.stream.in_flight() == 0);
}

TEST_CASE("numbers go round, and words are told apart all the same", "[net]") {
  StreamBench bench;
  bench.wanted = {1};
  bench.say();
  for (Version v = 1; v <= 66000; ++v) {
    REQUIRE(bench.ours.put(0, net::status_record(1), v, Lane::ground, {}) == LayerStore::Put::stored);
    for (const Lane lane : net::kAllLanes) REQUIRE(bench.ours.add_had(0, lane, {0, v}));
    StreamDatagram datagram;
    REQUIRE(bench.next(datagram));
    REQUIRE(datagram.sequence == (v & 0xFFFFU));
    bench.take(datagram);
    bench.seen.data = datagram.sequence;
    bench.say();
    REQUIRE(bench.stream.in_flight() == 0);
  }
  CHECK(bench.theirs.upto(0)[0] == 66000);
}
