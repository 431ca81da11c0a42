// SPDX-License-Identifier: Apache-2.0
#include "net/news_stream.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/net/stream_bench.hpp"

using namespace g3d;
using net::Lane;
using tests::kStreamMs;
using tests::StreamDatagram;

namespace {

/// One who sends layer 1, and some who want it.
class NewsBench {
 public:
  explicit NewsBench(net::RobotId receivers)
      : store_(net::StoreLimits{4, 5000, 2'000'000}), members_(receivers, 4, net::MembershipRule{}) {
    const net::LayerId self{1, 1};
    REQUIRE(store_.find_or_add(self) == 0);
    for (net::RobotId robot = 2; robot < 2 + receivers; ++robot) want(robot, 0);
  }
  void publish(Lane lane, std::size_t bytes, int records = 1) {
    for (int i = 0; i < records; ++i) {
      ++version_;
      REQUIRE(store_.put(0, net::block_record(0, version_, net::Part::whole), version_, lane,
                         mapper::Bytes(bytes, 7)) == net::LayerStore::Put::stored);
      for (const Lane each : net::kAllLanes) REQUIRE(store_.add_had(0, each, {0, version_}));
    }
  }
  /// Its word: it has all up to a version, and has seen news up to that number.
  void want(net::RobotId robot, net::Version upto, std::uint16_t news = 0) {
    net::Peer* peer = members_.heard({robot, 1, robot}, now_ns_);
    REQUIRE(peer != nullptr);
    const net::VersionRanges had(upto);
    net::WantedLayer wanted;
    wanted.layer = net::alias_of(net::LayerId{1, 1});
    wanted.had.fill(had);
    peer->out.on_want(store_, {0, news}, news_.next_sequence(), {&wanted, 1}, now_ns_);
  }
  bool next(StreamDatagram& datagram) { return took(news_.next(store_, members_, message_, now_ns_), datagram); }
  bool next_alone(net::RobotId robot, StreamDatagram& datagram) {
    return took(members_.find(robot)->out.next(store_, message_, now_ns_), datagram);
  }
  [[nodiscard]] bool sends_alone(net::RobotId robot) {
    StreamDatagram datagram;
    return next_alone(robot, datagram);
  }
  void wait(hal::TimeNs duration_ns) {
    now_ns_ += duration_ns;
    members_.on_time(now_ns_);
  }

 private:
  bool took(bool is_written, StreamDatagram& datagram) {
    datagram = {};
    if (!is_written) return false;
    REQUIRE(message_.size() <= net::kMostMessage_bytes);
    datagram.bytes.assign(message_.bytes().begin(), message_.bytes().end());
    tests::StreamReader reader(datagram);
    REQUIRE(net::read_data(datagram.bytes, datagram.sequence, &reader) == net::MessageFault::none);
    return true;
  }

  net::LayerStore store_;
  net::Membership members_;
  net::NewsStream news_{16};
  net::MessageWriter message_;
  net::Version version_ = 0;
  hal::TimeNs now_ns_ = 1000 * kStreamMs;
};

}  // namespace

TEST_CASE("what several want goes once, to all, and to nobody alone", "[net][gossip]") {
  NewsBench bench(3);
  StreamDatagram news;
  CHECK_FALSE(bench.next(news));
  bench.publish(Lane::rest, 100, 3);
  bench.publish(Lane::ground, 100, 2);
  REQUIRE(bench.next(news));
  CHECK(news.bytes[0] == static_cast<std::uint8_t>(net::MessageKind::news));
  CHECK(news.sequence == 1);
  CHECK(news.records.size() == 5);
  CHECK(news.segments.at(0).lane == Lane::ground);
  CHECK_FALSE(bench.next(news));
  for (const net::RobotId robot : {2U, 3U, 4U}) CHECK_FALSE(bench.sends_alone(robot));
  for (const net::RobotId robot : {2U, 3U, 4U}) bench.want(robot, 5, 1);
  CHECK_FALSE(bench.next(news));
  for (const net::RobotId robot : {2U, 3U, 4U}) CHECK_FALSE(bench.sends_alone(robot));
}

TEST_CASE("what one alone wants goes to it alone, and from where two want it to both", "[net][gossip]") {
  NewsBench one(1);
  StreamDatagram datagram;
  one.publish(Lane::ground, 100, 3);
  CHECK_FALSE(one.next(datagram));
  REQUIRE(one.next_alone(2, datagram));
  CHECK(datagram.bytes[0] == static_cast<std::uint8_t>(net::MessageKind::data));

  // The third is far behind: news reach it, what is older it gets alone.
  NewsBench bench(3);
  bench.publish(Lane::ground, 100, 6);
  bench.want(2, 4);
  bench.want(3, 4);
  REQUIRE(bench.next(datagram));
  REQUIRE(datagram.segments.size() == 3);
  CHECK(datagram.segments[0].range == net::VersionRange{4, 6});
  CHECK_FALSE(bench.next(datagram));
  CHECK_FALSE(bench.sends_alone(2));
  CHECK_FALSE(bench.sends_alone(3));
  REQUIRE(bench.next_alone(4, datagram));
  CHECK(datagram.segments.at(0).range == net::VersionRange{0, 4});
}

TEST_CASE("whoever misses news is sent them alone, and several who miss the same together", "[net][gossip]") {
  NewsBench bench(4);
  bench.publish(Lane::ground, 1000, 3);
  StreamDatagram news;
  for (int i = 0; i < 3; ++i) REQUIRE(bench.next(news));
  REQUIRE_FALSE(bench.next(news));
  bench.wait(200 * kStreamMs);
  bench.want(2, 3, 3);
  bench.want(3, 1, 3);
  bench.want(4, 1, 3);
  bench.want(5, 2, 3);
  REQUIRE(bench.next(news));
  CHECK(news.segments.at(0).range == net::VersionRange{1, 2});
  REQUIRE(bench.next(news));  // the third record all three miss
  CHECK(news.segments.at(0).range == net::VersionRange{2, 3});
  CHECK_FALSE(bench.next(news));
  for (const net::RobotId robot : {2U, 3U, 4U, 5U}) CHECK_FALSE(bench.sends_alone(robot));
}

TEST_CASE("nobody waits for who is silent or has too much under way", "[net][gossip]") {
  NewsBench bench(3);
  StreamDatagram news;
  bench.publish(Lane::ground, 1000, 100);
  int sent = 0;
  while (bench.next(news)) ++sent;
  CHECK(sent == static_cast<int>(net::OutgoingStream::kMostInFlight));
  bench.wait(4'000 * kStreamMs);  // all three are suspect
  CHECK_FALSE(bench.next(news));
  bench.want(2, 64, 64);
  CHECK_FALSE(bench.next(news));  // one is not several
  bench.want(3, 64, 64);
  REQUIRE(bench.next(news));
}
