// SPDX-License-Identifier: Apache-2.0
#include "net/membership.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using hal::TimeNs;
using net::Membership;
using net::Peer;
using net::PeerState;

namespace {

constexpr TimeNs kMemberSecond = 1'000'000'000;
constexpr net::MembershipRule kMemberRule{2 * kMemberSecond, 5 * kMemberSecond};

/// As after a long talk.
void fill_peer(Peer& peer) {
  peer.digest = 77;
  peer.known[1] = {{4, 5, 6}, 9, 123, 456};
  peer.seen = {31, 32};
  peer.unanswered = 2;
  peer.silent_wants = 3;
  peer.owes_want = false;
  peer.owes_vector = true;
  peer.data_ns = peer.want_ns = peer.vector_asked_ns = kMemberSecond;
}

void check_nothing_is_known(const Peer& peer) {
  CHECK(peer.digest == 0);
  for (const net::KnownLayer& known : peer.known) {
    CHECK(known.upto == net::LaneVersions{});
    CHECK(known.highest == 0);
    CHECK(known.content_hash == 0);
    CHECK(known.taken_hash == 0);
  }
  CHECK(peer.seen == net::SeenNumbers{});
  CHECK(peer.unanswered == 0);
  CHECK(peer.silent_wants == 0);
  CHECK_FALSE(peer.owes_vector);
  CHECK(peer.data_ns == 0);
  CHECK(peer.want_ns == 0);
  CHECK(peer.vector_asked_ns == 0);
  CHECK(peer.out.in_flight() == 0);
}

/// Something to send, and a word that wants it.
class MemberTalk {
 public:
  MemberTalk() {
    const net::LayerIndex layer = store_.find_or_add({9, 1});
    REQUIRE(store_.put(layer, net::status_record(1), 1, net::Lane::ground, {}) == net::LayerStore::Put::stored);
    REQUIRE(store_.add_had(layer, net::Lane::ground, {0, 1}));
  }
  void want(Peer& peer, TimeNs now_ns) {
    const net::WantedLayer wanted{net::alias_of(net::LayerId{9, 1}), {}};
    peer.out.on_want(store_, {}, 1, {&wanted, 1}, now_ns);
  }
  bool sends(Peer& peer, TimeNs now_ns) { return peer.out.next(store_, message_, now_ns); }

 private:
  net::LayerStore store_{{2, 10, 1000}};
  net::MessageWriter message_;
};

}  // namespace

TEST_CASE("whoever is heard is alive, is found and may move", "[net]") {
  Membership members(3, 4, kMemberRule);
  CHECK(members.find(7) == nullptr);
  CHECK(members.all().empty());
  Peer* peer = members.heard({7, 100, 2}, kMemberSecond);
  REQUIRE(peer != nullptr);
  CHECK(members.find(7) == peer);
  CHECK(peer->robot == 7);
  CHECK(peer->session == 100);
  CHECK(peer->address == 2);
  CHECK(peer->heard_ns == kMemberSecond);
  CHECK(peer->is_alive());
  REQUIRE(peer->known.size() == 4);
  check_nothing_is_known(*peer);
  CHECK(members.heard({8, 100, 3}, kMemberSecond) != peer);
  CHECK(members.heard({7, 100, 5}, 2 * kMemberSecond) == peer);
  CHECK(peer->address == 5);
  CHECK(members.find(8)->address == 3);
  CHECK(members.all().size() == 2);
}

TEST_CASE("whoever is not heard is suspect, then gone, and alive when heard again", "[net]") {
  Membership members(3, 1, kMemberRule);
  Peer& silent = *members.heard({1, 1, 1}, 0);
  Peer& speaking = *members.heard({2, 1, 2}, 0);
  for (TimeNs now_ns = 0; now_ns <= 8 * kMemberSecond; now_ns += kMemberSecond / 10) {
    if (now_ns % kMemberSecond == 0) (void)members.heard({2, 1, 2}, now_ns);
    members.on_time(now_ns);
    INFO(now_ns << " ns");
    REQUIRE(silent.state == (now_ns > 5 * kMemberSecond   ? PeerState::gone
                             : now_ns > 2 * kMemberSecond ? PeerState::suspect
                                                          : PeerState::alive));
    REQUIRE(speaking.is_alive());
  }
  CHECK(members.heard({1, 1, 1}, 9 * kMemberSecond) == &silent);
  CHECK(silent.is_alive());
  members.on_time(9 * kMemberSecond);
  CHECK(silent.is_alive());
}

TEST_CASE("another session makes void all that was known of a robot, the same one nothing", "[net]") {
  Membership members(3, 4, kMemberRule);
  MemberTalk talk;
  Peer& peer = *members.heard({1, 50, 1}, 0);
  fill_peer(peer);
  talk.want(peer, 0);
  REQUIRE(talk.sends(peer, 0));
  members.on_time(100 * kMemberSecond);
  REQUIRE(peer.state == PeerState::gone);
  // Away for long, but the same program.
  (void)members.heard({1, 50, 1}, 100 * kMemberSecond);
  CHECK(peer.digest == 77);
  CHECK(peer.known[1].upto == net::LaneVersions{4, 5, 6});
  CHECK(peer.seen == net::SeenNumbers{31, 32});
  CHECK(peer.owes_vector);
  CHECK_FALSE(peer.owes_want);
  CHECK(peer.out.in_flight() == 1);
  // It may come back with a lower number just as well.
  for (const std::uint64_t session : {51U, 3U}) {
    (void)members.heard({1, session, 1}, 100 * kMemberSecond);
    CHECK(peer.session == session);
    check_nothing_is_known(peer);
    CHECK(peer.owes_want);  // it does not know what we asked it for
    CHECK_FALSE(talk.sends(peer, 200 * kMemberSecond));
    fill_peer(peer);
    talk.want(peer, 200 * kMemberSecond);
    REQUIRE(talk.sends(peer, 200 * kMemberSecond));
  }
  CHECK(members.all().size() == 1);
}

TEST_CASE("when there are too many, who is new takes the place of whoever is gone for longest", "[net]") {
  Membership members(3, 4, kMemberRule);
  MemberTalk talk;
  for (net::RobotId robot = 1; robot <= 3; ++robot) {
    fill_peer(*members.heard({robot, 1, robot}, static_cast<TimeNs>(robot == 2 ? 0 : robot) * kMemberSecond));
  }
  talk.want(*members.find(2), 0);
  REQUIRE(talk.sends(*members.find(2), 0));
  members.on_time(4 * kMemberSecond);
  CHECK(members.find(2)->state == PeerState::suspect);
  CHECK(members.heard({4, 1, 4}, 4 * kMemberSecond) == nullptr);
  CHECK(members.refused() == 1);
  CHECK(members.find(4) == nullptr);
  CHECK(members.heard({3, 1, 3}, 4 * kMemberSecond) != nullptr);  // who is known is never refused

  members.on_time(20 * kMemberSecond);
  const Peer* place = members.find(2);
  const Peer* added = members.heard({4, 9, 4}, 20 * kMemberSecond);
  REQUIRE(added == place);
  CHECK(added->robot == 4);
  CHECK(added->session == 9);
  CHECK(added->is_alive());
  check_nothing_is_known(*added);
  CHECK(members.find(2) == nullptr);
  CHECK(members.find(1) != nullptr);
  CHECK(members.refused() == 1);
  REQUIRE(members.heard({5, 1, 5}, 20 * kMemberSecond) != nullptr);
  CHECK(members.find(1) == nullptr);
  CHECK(members.find(3)->digest == 77);
  CHECK(members.all().size() == 3);
}

TEST_CASE("a membership for nobody refuses everybody", "[net]") {
  Membership members(0, 4, kMemberRule);
  CHECK(members.heard({1, 1, 1}, 0) == nullptr);
  members.on_time(100 * kMemberSecond);
  CHECK(members.heard({1, 1, 1}, 200 * kMemberSecond) == nullptr);
  CHECK(members.refused() == 2);
}

TEST_CASE("members that come, stay silent and come back are those of a plain list", "[net]") {
  constexpr std::size_t kMost = 4;
  tests::Random random(6);
  Membership members(kMost, 1, kMemberRule);
  std::map<net::RobotId, TimeNs> plain;  // when heard
  std::uint64_t refused = 0;
  TimeNs now_ns = 0;
  for (int step = 0; step < 5000; ++step) {
    now_ns += 1 + random.below(2 * static_cast<std::uint32_t>(kMemberSecond));
    members.on_time(now_ns);
    const net::RobotId robot = 1 + random.below(9);
    const auto longest =
        std::min_element(plain.begin(), plain.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    if (!plain.contains(robot) && plain.size() == kMost) {
      if (now_ns - longest->second > kMemberRule.gone_after_ns) {
        plain.erase(longest);
      } else {
        ++refused;
      }
    }
    const bool is_taken = plain.contains(robot) || plain.size() < kMost;
    REQUIRE((members.heard({robot, 1, robot}, now_ns) != nullptr) == is_taken);
    if (is_taken) plain[robot] = now_ns;
    REQUIRE(members.refused() == refused);
    REQUIRE(members.all().size() == plain.size());
    for (const auto& [known, heard_ns] : plain) {
      REQUIRE(members.find(known) != nullptr);
      REQUIRE(members.find(known)->heard_ns == heard_ns);
    }
  }
  CHECK(refused > 100);
}
