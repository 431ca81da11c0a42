// SPDX-License-Identifier: Apache-2.0
#include "net/layer_sources.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using hal::TimeNs;
using net::LayerIndex;
using net::LayerSources;
using net::RobotId;

namespace {

constexpr TimeNs kSourceMs = 1'000'000;
constexpr TimeNs kSourcePatience = 1000 * kSourceMs;
constexpr RobotId kWriter = 20;

/// Our own layer and one of kWriter; robots 10, 20 and 30 are about, and have nothing.
class SourceBench {
 public:
  SourceBench() {
    own_ = store_.find_or_add({1, 1});
    layer_ = store_.find_or_add({kWriter, 1});
    for (const RobotId robot : {10U, 20U, 30U}) appear(robot);
    settle();
  }
  void appear(RobotId robot) { (void)members_.heard({robot, 1, robot}, now_ns_); }
  void set_state(RobotId robot, net::PeerState state) { peer(robot).state = state; }
  /// So much of the layer's ground lane is known to be there.
  void knows(RobotId robot, net::Version upto) {
    peer(robot).known[layer_].upto[0] = upto;
    peer(robot).known[layer_].highest = upto;
  }
  void come(net::Version upto) {
    REQUIRE(store_.add_had(layer_, net::Lane::ground, {0, upto}));
    sources_.note_progress(layer_, now_ns_);
  }
  /// The time goes on, without a choice on the way.
  RobotId choose_after(TimeNs ns) {
    now_ns_ += ns;
    sources_.choose(store_, members_, own_, now_ns_);
    return sources_.source(layer_);
  }
  void settle() {
    (void)choose_after(0);
    for (net::Peer& each : members_.all()) each.owes_want = false;
  }
  [[nodiscard]] bool owes(RobotId robot) { return peer(robot).owes_want; }
  [[nodiscard]] net::Peer& peer(RobotId robot) { return *members_.find(robot); }

  [[nodiscard]] net::LayerStore& store() { return store_; }
  [[nodiscard]] net::Membership& members() { return members_; }
  [[nodiscard]] LayerSources& sources() { return sources_; }
  [[nodiscard]] LayerIndex own() const { return own_; }
  [[nodiscard]] LayerIndex layer() const { return layer_; }
  [[nodiscard]] TimeNs now_ns() const { return now_ns_; }

 private:
  net::LayerStore store_{{4, 10, 1000}};
  net::Membership members_{8, 4};
  LayerSources sources_{4, {kSourcePatience}};
  LayerIndex own_ = 0, layer_ = 0;
  TimeNs now_ns_ = 5000 * kSourceMs;
};

}  // namespace

TEST_CASE("a peer has more if it is further in any lane, or has something higher anywhere", "[net]") {
  SourceBench bench;
  REQUIRE(bench.store().add_had(bench.layer(), net::Lane::ground, {0, 10}));
  REQUIRE(bench.store().add_had(bench.layer(), net::Lane::rest, {0, 5}));
  REQUIRE(bench.store().add_had(bench.layer(), net::Lane::rest, {8, 12}));
  net::KnownLayer& known = bench.peer(30).known[bench.layer()];
  const auto has_more = [&] { return LayerSources::has_more(bench.store(), bench.peer(30), bench.layer()); };
  CHECK_FALSE(has_more());
  known = {{10, 0, 5}, 12, 0, 0};
  CHECK_FALSE(has_more());
  known = {{10, 0, 6}, 12, 0, 0};
  CHECK(has_more());
  known = {{10, 1, 0}, 1, 0, 0};
  CHECK(has_more());
  known = {{0, 0, 0}, 13, 0, 0};
  CHECK(has_more());
}

TEST_CASE("the writer of a layer is asked first, though others have more of it", "[net]") {
  SourceBench bench;
  CHECK(bench.choose_after(0) == kWriter);
  bench.knows(10, 100);
  bench.knows(30, 200);
  bench.knows(kWriter, 50);
  CHECK(bench.choose_after(50 * kSourceMs) == kWriter);
  CHECK_FALSE(bench.owes(kWriter));  // nothing has changed for anybody
  CHECK(bench.sources().source(bench.own()) == LayerSources::kNobody);
}

TEST_CASE("when its writer is gone, a layer is asked for from one who has more, and from no one else", "[net]") {
  SourceBench bench;
  bench.set_state(kWriter, net::PeerState::suspect);
  bench.knows(30, 5);
  CHECK(bench.choose_after(0) == 30);
  CHECK(bench.owes(30));
  CHECK(bench.owes(kWriter));
  CHECK_FALSE(bench.owes(10));
  bench.settle();
  // It stays, although another one is better.
  bench.knows(10, 500);
  CHECK(bench.choose_after(100 * kSourceMs) == 30);
  CHECK_FALSE(bench.owes(10));
  // Until it has given all that it has.
  bench.come(5);
  CHECK(bench.choose_after(0) == 10);
  CHECK(bench.owes(10));
  CHECK(bench.owes(30));
  // Whoever gave all may get more: it stays as long as nobody has more.
  bench.come(500);
  CHECK(bench.choose_after(0) == 10);
}

TEST_CASE("a layer that nobody has is nobody's once its writer is gone", "[net]") {
  SourceBench bench;
  bench.set_state(kWriter, net::PeerState::gone);
  bench.knows(kWriter, 50);
  CHECK(bench.choose_after(0) == LayerSources::kNobody);
  CHECK(bench.owes(kWriter));
  CHECK_FALSE(bench.owes(10));
  bench.appear(kWriter);
  CHECK(bench.choose_after(0) == kWriter);
}

TEST_CASE("a writer that has more and gives nothing is passed over for another one", "[net]") {
  SourceBench bench;
  bench.knows(kWriter, 50);
  bench.knows(10, 50);
  CHECK(bench.choose_after(0) == kWriter);
  CHECK(bench.choose_after(kSourcePatience) == kWriter);
  CHECK(bench.choose_after(1) == 10);
  CHECK(bench.owes(kWriter));
  CHECK(bench.owes(10));
  // The other one gets its time, too, and then the writer is next again.
  CHECK(bench.choose_after(0) == 10);
  CHECK(bench.choose_after(kSourcePatience) == 10);
  CHECK(bench.choose_after(1) == kWriter);
}

TEST_CASE("whatever comes renews the patience", "[net]") {
  SourceBench bench;
  bench.knows(kWriter, 1000);
  bench.knows(10, 1000);
  for (net::Version v = 1; v <= 20; ++v) {
    CHECK(bench.choose_after(kSourcePatience * 3 / 4) == kWriter);
    bench.come(v);
  }
  CHECK(bench.choose_after(kSourcePatience + 1) == 10);
}

TEST_CASE("time in which nobody has more does not count as patience", "[net]") {
  SourceBench bench;
  CHECK(bench.choose_after(100 * kSourcePatience) == kWriter);
  CHECK(bench.sources().progress_ns(bench.layer()) == bench.now_ns());
  bench.knows(kWriter, 50);
  bench.knows(30, 50);
  CHECK(bench.choose_after(kSourcePatience) == kWriter);
  CHECK(bench.choose_after(1) == 30);
}

TEST_CASE("those that give nothing are asked in turns, and all have their turn", "[net]") {
  SourceBench bench;
  bench.appear(40);
  for (const RobotId robot : {10U, 30U, 40U}) bench.knows(robot, 7);
  bench.set_state(kWriter, net::PeerState::gone);
  std::vector<RobotId> asked;
  for (int i = 0; i < 7; ++i) asked.push_back(bench.choose_after(kSourcePatience + 1));
  CHECK(asked == std::vector<RobotId>{30, 40, 10, 30, 40, 10, 30});
  // One alone is asked again and again.
  for (const RobotId robot : {30U, 40U}) bench.set_state(robot, net::PeerState::gone);
  CHECK(bench.choose_after(0) == 10);
  CHECK(bench.choose_after(kSourcePatience + 1) == 10);
}

TEST_CASE("back to the writer it goes when nothing is under way from another", "[net]") {
  SourceBench bench;
  bench.set_state(kWriter, net::PeerState::gone);
  bench.knows(30, 50);
  REQUIRE(bench.choose_after(0) == 30);
  bench.appear(kWriter);
  bench.knows(kWriter, 60);
  CHECK(bench.choose_after(0) == 30);  // in the middle of it
  bench.come(60);
  bench.settle();
  CHECK(bench.choose_after(0) == kWriter);
  bench.set_state(kWriter, net::PeerState::gone);
  bench.knows(30, 90);
  REQUIRE(bench.choose_after(0) == 30);
  bench.appear(kWriter);
  bench.settle();
  bench.set_state(30, net::PeerState::suspect);
  CHECK(bench.choose_after(0) == kWriter);  // the other one is not there any more
  CHECK(bench.owes(kWriter));
  CHECK(bench.owes(30));
}

TEST_CASE("whoever is asked in particular stays the source as long as it has more", "[net]") {
  SourceBench bench;
  bench.knows(30, 50);
  bench.sources().ask(bench.layer(), bench.members(), 30);
  CHECK(bench.sources().source(bench.layer()) == 30);
  CHECK(bench.owes(kWriter));
  CHECK(bench.owes(30));
  CHECK_FALSE(bench.owes(10));
  CHECK(bench.choose_after(0) == 30);
  bench.come(50);
  CHECK(bench.choose_after(0) == kWriter);
}

TEST_CASE("layers have their sources each for itself", "[net]") {
  SourceBench bench;
  const LayerIndex other = bench.store().find_or_add({30, 4});
  const LayerIndex orphan = bench.store().find_or_add({99, 1});
  bench.peer(10).known[orphan] = {{1, 0, 0}, 1, 0, 0};
  CHECK(bench.choose_after(0) == kWriter);
  CHECK(bench.sources().source(other) == 30);
  CHECK(bench.sources().source(orphan) == 10);
  CHECK(bench.sources().source(bench.own()) == LayerSources::kNobody);
}
