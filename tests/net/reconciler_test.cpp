// SPDX-License-Identifier: Apache-2.0
#include "net/reconciler.hpp"

#include <catch2/catch.hpp>
#include <deque>
#include <memory>

#include "tests/support/sample_maps.hpp"

using namespace g3d;

namespace {

constexpr net::RobotId kHere = 1;
constexpr net::RobotId kThere = 2;
const net::LayerId kDeadWriter{9, 1};

/// Two robots with a layer each, and a line between them that may lose messages.
struct TwoHolders {
  explicit TwoHolders(net::ReconcilerOptions options = {}, double loss = 0.0, std::uint64_t seed = 7)
      : loss_share(loss) {
    options.seed = seed;
    here = std::make_unique<net::Reconciler>(
        options, here_store, [this](net::RobotId, const net::WireWriter& message) { send(kThere, message); });
    there = std::make_unique<net::Reconciler>(
        options, there_store, [this](net::RobotId, const net::WireWriter& message) { send(kHere, message); });
    layer_here = here_store.find_or_add(kDeadWriter);
    layer_there = there_store.find_or_add(kDeadWriter);
  }
  void send(net::RobotId to, const net::WireWriter& message) {
    sent_bytes += message.size();
    if (random.uniform(0.0, 1.0) < loss_share) return;
    line.push_back({to, {message.bytes().begin(), message.bytes().end()}});
  }
  void put(net::LayerStore& store, net::LayerIndex layer, net::Version version) {
    const std::uint64_t chance = net::mixed(version, 1);
    const mapper::Bytes payload(chance % 90, static_cast<std::uint8_t>(chance));
    (void)store.put(layer, net::block_record(0, version * 8, net::Part::whole), version,
                    static_cast<net::Lane>(chance % 3), payload);
  }
  /// Until nothing is open.
  void run() {
    for (int i = 0; i < 4000 && (here->is_busy() || there->is_busy()); ++i) {
      now_ns += 10'000'000;
      std::deque<std::pair<net::RobotId, mapper::Bytes>> arrived;
      arrived.swap(line);
      for (const auto& [to, message] : arrived) {
        net::Reconciler& at = to == kHere ? *here : *there;
        REQUIRE(at.on_message(to == kHere ? kThere : kHere, message, now_ns) == net::MessageFault::none);
      }
      here->on_time(now_ns);
      there->on_time(now_ns);
    }
  }

  net::LayerStore here_store{{4, 1U << 15, std::size_t{4} << 20}};
  net::LayerStore there_store{{4, 1U << 15, std::size_t{4} << 20}};
  net::LayerIndex layer_here = 0, layer_there = 0;
  std::unique_ptr<net::Reconciler> here, there;
  std::deque<std::pair<net::RobotId, mapper::Bytes>> line;
  tests::Random random{3};
  double loss_share;
  std::uint64_t sent_bytes = 0;
  hal::TimeNs now_ns = 1'000'000'000;
};

}  // namespace

TEST_CASE("two holders of a layer learn what each lacks, at the cost of what differs", "[net][reconcile]") {
  const net::Version missing = GENERATE(0U, 1U, 7U, 60U, 600U);
  TwoHolders two;
  constexpr net::Version kAll = 20000;
  for (net::Version v = 1; v <= kAll; ++v) {
    two.put(two.there_store, two.layer_there, v);
    // What is missing lies anywhere.
    if (missing == 0 || v % (kAll / missing) != 0) two.put(two.here_store, two.layer_here, v);
  }
  for (const net::Lane lane : net::kAllLanes) REQUIRE(two.there_store.add_had(two.layer_there, lane, {0, kAll}));
  two.here_store.set_unclaimed(two.layer_here, true);
  two.here->begin(kThere, two.layer_here, two.now_ns);
  two.run();
  const net::ReconcilerCounts& counts = two.here->counts();
  CHECK(counts.ended_equal == 1);
  const auto finished = two.here->take_finished();
  REQUIRE(finished);
  CHECK(finished->peer == kThere);
  CHECK(finished->their_content == two.there_store.content_hash(two.layer_there));
  CHECK_FALSE(two.here->take_finished());
  CHECK(counts.differences == counts.recovered_records);
  CHECK(counts.recovered_records >= missing);
  CHECK(counts.asked_symbols <= 16 + 2 * counts.differences);
  CHECK(two.here_store.content_hash(two.layer_here) == two.there_store.content_hash(two.layer_there));
  CHECK(two.here_store.upto(two.layer_here) == net::LaneVersions{kAll, kAll, kAll});
  CHECK_FALSE(two.here_store.is_unclaimed(two.layer_here));
  CHECK(two.sent_bytes < 1500 + 250 * missing);
}

TEST_CASE("few differences cost 1.8 symbols each at most, on average", "[net][reconcile]") {
  const net::Version missing = GENERATE(1U, 2U, 3U, 5U, 8U, 16U, 32U, 63U);
  constexpr net::Version kAll = 1000;
  constexpr int kExchanges = 60;
  double symbols = 0;
  for (int i = 0; i < kExchanges; ++i) {
    TwoHolders two({}, 0.0, 100 * missing + static_cast<std::uint64_t>(i));
    for (net::Version v = 1; v <= kAll; ++v) {
      two.put(two.there_store, two.layer_there, v);
      if (v > missing) two.put(two.here_store, two.layer_here, v);
    }
    two.here->begin(kThere, two.layer_here, two.now_ns);
    two.run();
    REQUIRE(two.here->counts().differences == missing);
    symbols += static_cast<double>(two.here->counts().asked_symbols);
  }
  CAPTURE(missing, symbols / kExchanges);
  CHECK(symbols <= 1.8 * static_cast<double>(missing) * kExchanges);
}

TEST_CASE("lost messages are asked for again", "[net][reconcile]") {
  TwoHolders two({}, 0.4);
  for (net::Version v = 1; v <= 3000; ++v) {
    if (v % 7 != 0) two.put(two.here_store, two.layer_here, v);
    if (v % 11 != 0) two.put(two.there_store, two.layer_there, v);
  }
  for (int i = 0; i < 10 && two.here->counts().ended_equal == 0; ++i) {
    two.here->begin(kThere, two.layer_here, two.now_ns);
    two.run();
  }
  for (int i = 0; i < 10 && two.there->counts().ended_equal == 0; ++i) {
    two.there->begin(kHere, two.layer_there, two.now_ns);
    two.run();
  }
  CHECK(two.here_store.content_hash(two.layer_here) == two.there_store.content_hash(two.layer_there));
}

TEST_CASE("an exchange ends when the layer changes under it, when too much differs, and when nobody answers",
          "[net][reconcile]") {
  net::ReconcilerOptions options;
  options.most_differences = 50;
  TwoHolders two(options);
  for (net::Version v = 1; v <= 300; ++v) two.put(two.there_store, two.layer_there, v);
  two.here_store.set_unclaimed(two.layer_here, true);
  two.here->begin(kThere, two.layer_here, two.now_ns);
  two.run();
  CHECK(two.here->counts().ended_refused == 1);
  CHECK(two.here->take_finished());
  CHECK_FALSE(two.here_store.is_unclaimed(two.layer_here));

  for (net::Version v = 1; v <= 280; ++v) two.put(two.here_store, two.layer_here, v);
  two.here->begin(kThere, two.layer_here, two.now_ns);
  two.put(two.here_store, two.layer_here, 281);
  two.run();
  CHECK(two.here->counts().ended_changed == 1);

  two.loss_share = 1.0;
  two.here->begin(kThere, two.layer_here, two.now_ns);
  two.run();
  CHECK(two.here->counts().ended_silent == 1);
  // What was broken off is to be tried again.
  CHECK_FALSE(two.here->take_finished());
}
