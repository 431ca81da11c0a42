// SPDX-License-Identifier: Apache-2.0
#include "nav/explorer.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "tests/support/flat_explore.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

constexpr TimeNs kSecond = 1'000'000'000;

struct Run {
  explicit Run(std::string_view plan, std::uint64_t seed = 1) : world(tests::make_flat_world(plan, seed)) {
    start = tests::choose_start(world, seed);
    const auto room = tests::standing_room(world.solid);
    const auto reachable = tests::connected_part(room, room.cell_of(start.x_m, start.y_m));
    observable = tests::observable_cells(world.solid, reachable, 0.8, 3.5);
    sim = std::make_unique<tests::FlatSim>(world, start);
    sim->set_observable(&observable);
  }
  tests::FlatWorld world;
  hal::PlanarPose start;
  CellGrid<std::uint8_t> observable;
  std::unique_ptr<tests::FlatSim> sim;
};

}  // namespace

TEST_CASE("a whole floor is seen, the robot comes home and says why it left the rest", "[slow]") {
  for (const std::string_view plan : {"house", "narrow_doors"}) {
    Run run(plan);
    const tests::FlatResult result = tests::run_explorer(*run.sim, 3000.0);
    INFO(plan << result.left);
    CHECK(result.ended);
    CHECK(result.home);
    CHECK(result.coverage >= 0.99);
    CHECK(result.t95_s > 0);
    CHECK(result.t99_s >= result.t95_s);
  }
}

TEST_CASE("the same world and start give the same drive", "[slow]") {
  Run a("lab", 3);
  Run b("lab", 3);
  const tests::FlatResult ra = tests::run_explorer(*a.sim, 120.0);
  const tests::FlatResult rb = tests::run_explorer(*b.sim, 120.0);
  CHECK(a.sim->pose() == b.sim->pose());
  CHECK(a.sim->ground().cells == b.sim->ground().cells);
  CHECK(ra.goals == rb.goals);
}

TEST_CASE("it begins with a look around and ends where it began") {
  Run run("house");
  Explorer explorer{ExplorerConfig{}};
  Decision d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, 0);
  CHECK(d.kind == DecisionKind::look_around);
  CHECK(d.is_new);
  CHECK(d.turn_rad == Approx(6.2831853));
  d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, kSecond);
  CHECK(d.kind == DecisionKind::look_around);
  CHECK_FALSE(d.is_new);
  explorer.goal_reached();
  d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), run.sim->take_changed(), run.start,
                            2 * kSecond);
  CHECK(d.kind == DecisionKind::goal);
  CHECK(d.left.open > 0);
  CHECK_FALSE(explorer.frontier_cells().empty());
  explorer.return_home(false);
  d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, {1.0, 1.0, 0.0}, 3 * kSecond);
  CHECK(d.kind == DecisionKind::go_home);
  CHECK(d.is_new);
  CHECK(d.goal == run.start);
  explorer.goal_reached();
  d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, 4 * kSecond);
  CHECK(d.kind == DecisionKind::done);
}

TEST_CASE("goals that fail are set aside, and in the end it gives up by name") {
  Run run("house");
  ExplorerConfig config;
  config.look_around_first = false;
  config.set_aside_s = 5.0;
  Explorer explorer(config);
  TimeNs now = 0;
  Decision d;
  PlanarPose last;
  int repeats = 0;
  int goals = 0;
  for (; goals < 2000; ++goals, now += kSecond) {
    d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, now);
    if (d.kind != DecisionKind::goal) break;
    repeats += goals > 0 && d.goal == last;
    last = d.goal;
    explorer.goal_failed(GoalFailure::no_path);
  }
  CHECK(d.kind != DecisionKind::goal);
  CHECK(repeats == 0);
  CHECK(goals > 3);
  CHECK(d.left[LeftReason::blocked] > 0);
  CHECK(d.left.open == 0);
}

TEST_CASE("a way home that keeps failing ends too") {
  Run run("house");
  Explorer explorer{ExplorerConfig{}};
  (void)tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, 0);
  explorer.return_home(false);
  Decision d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, {1.0, 1.0, 0.0}, kSecond);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(d.kind == DecisionKind::go_home);
    explorer.goal_failed(GoalFailure::stuck);
    d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, {1.0, 1.0, 0.0}, (i + 2) * kSecond);
  }
  CHECK(d.kind == DecisionKind::done);
}

TEST_CASE("a low battery ends exploration early") {
  Run run("house");
  ExplorerConfig config;
  config.look_around_first = false;
  Explorer explorer(config);
  explorer.set_energy_left(20.0);
  const Decision d = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, 0);
  CHECK(d.kind != DecisionKind::goal);
  CHECK(d.left[LeftReason::energy] > 0);
}

TEST_CASE("who is sent home for the battery's sake says so of all that is still open") {
  for (const bool for_energy : {false, true}) {
    Run run("house");
    ExplorerConfig config;
    config.look_around_first = false;
    Explorer explorer(config);
    const Decision before = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, 0);
    REQUIRE(before.kind == DecisionKind::goal);
    REQUIRE(before.left.open > 0);
    explorer.return_home(for_energy);
    const Decision after = tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, kSecond);
    CHECK(after.kind != DecisionKind::goal);
    CHECK(after.left.open == (for_energy ? 0 : before.left.open));
    CHECK(after.left[LeftReason::energy] == (for_energy ? before.left.open : 0));
  }
}

TEST_CASE("it stays within the area, and what lies beyond is named so") {
  Run run("hall");
  ExplorerConfig config;
  config.area_min_x_m = run.start.x_m - 2.0;
  config.area_max_x_m = run.start.x_m + 2.0;
  config.area_min_y_m = run.start.y_m - 2.0;
  config.area_max_y_m = run.start.y_m + 2.0;
  Explorer explorer(config);
  (void)tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, 0);
  explorer.goal_reached();
  for (int i = 0; i < 63; ++i) run.sim->step(0.0, 1.0);
  const Decision d =
      tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), run.sim->take_changed(), run.start, kSecond);
  if (d.kind == DecisionKind::goal) {
    CHECK(std::abs(d.goal.x_m - run.start.x_m) <= 2.0);
    CHECK(std::abs(d.goal.y_m - run.start.y_m) <= 2.0);
  }
  const tests::FlatResult result = tests::run_explorer(*run.sim, 2000.0, config);
  CHECK(result.ended);
  CHECK(result.left.find("outside_area") != std::string::npos);
}

TEST_CASE("a grid of another geometry is read anew") {
  Run small("house");
  Run large("hall");
  ExplorerConfig config;
  config.look_around_first = false;
  Explorer explorer(config);
  (void)tests::decide_at_once(explorer, small.sim->ground(), small.sim->cost(), {}, small.start, 0);
  const Decision d = tests::decide_at_once(explorer, large.sim->ground(), large.sim->cost(), {}, large.start, kSecond);
  Explorer fresh(config);
  const Decision e = tests::decide_at_once(fresh, large.sim->ground(), large.sim->cost(), {}, large.start, kSecond);
  CHECK(d.kind == e.kind);
  CHECK(d.goal == e.goal);
}

TEST_CASE("one unit of work per call and all of it at once lead to the same goals on a frozen map") {
  Run run("house");
  ExplorerConfig config;
  config.look_around_first = false;
  config.max_units_per_call = std::numeric_limits<std::int64_t>::max();
  Explorer whole(config);
  config.max_units_per_call = 1;
  Explorer pieces(config);
  run.sim->step(0.0, 0.0);
  TimeNs now = 0;
  int goals = 0;
  for (; goals < 40; ++goals, now += kSecond) {
    const auto at_once = whole.decide(run.sim->ground(), run.sim->cost(), {}, run.start, now);
    REQUIRE(at_once);
    int calls = 1;
    auto in_pieces = pieces.decide(run.sim->ground(), run.sim->cost(), {}, run.start, now);
    for (; !in_pieces && calls < 10'000'000; ++calls) {
      in_pieces = pieces.decide(run.sim->ground(), run.sim->cost(), {}, run.start, now);
    }
    REQUIRE(in_pieces);
    CHECK(calls > 10);
    CHECK(in_pieces->kind == at_once->kind);
    CHECK(in_pieces->goal == at_once->goal);
    CHECK(in_pieces->is_new == at_once->is_new);
    CHECK(in_pieces->left == at_once->left);
    if (at_once->kind != DecisionKind::goal) break;
    whole.goal_failed(GoalFailure::no_path);
    pieces.goal_failed(GoalFailure::no_path);
  }
  CHECK(goals > 3);
}

TEST_CASE("no call does more than its share of work, on a large map as on a small one") {
  Run run("maze");
  for (int i = 0; i < 63; ++i) run.sim->step(0.0, 1.0);
  ExplorerConfig config;
  config.look_around_first = false;
  config.max_units_per_call = 2000;
  Explorer explorer(config);
  explorer.prepare(run.sim->ground(), run.sim->cost());
  int calls = 0;
  std::optional<Decision> decision;
  for (; !decision && calls < 100'000; ++calls) {
    decision = explorer.decide(run.sim->ground(), run.sim->cost(), {}, run.start, 0);
  }
  REQUIRE(decision);
  CHECK(decision->kind == DecisionKind::goal);
  config.max_units_per_call = 4000;
  Explorer faster(config);
  int faster_calls = 0;
  decision.reset();
  for (; !decision && faster_calls < 100'000; ++faster_calls) {
    decision = faster.decide(run.sim->ground(), run.sim->cost(), {}, run.start, 0);
  }
  CHECK(calls > 5);
  CHECK(faster_calls < 0.75 * calls);
}

TEST_CASE("a goal that is over while it decides is not chosen again by what was thought before") {
  Run run("house");
  ExplorerConfig config;
  config.look_around_first = false;
  config.max_units_per_call = 500;
  Explorer explorer(config);
  for (int i = 0; i < 63; ++i) run.sim->step(0.0, 1.0);
  const Decision first =
      tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), run.sim->take_changed(), run.start, 0);
  REQUIRE(first.kind == DecisionKind::goal);
  // Begins anew, as there is time for it and much has changed, and then the goal fails.
  std::vector<std::uint32_t> all(run.sim->ground().cells.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
  REQUIRE_FALSE(explorer.decide(run.sim->ground(), run.sim->cost(), all, run.start, 2 * kSecond));
  explorer.goal_failed(GoalFailure::no_path);
  const Decision second =
      tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, 2 * kSecond);
  CHECK_FALSE(second.goal == first.goal);
}

TEST_CASE("looks that show nothing end soon, by name, and starting again does not repeat them") {
  Run run("house");
  ExplorerConfig config;
  config.look_around_first = false;
  config.set_aside_s = 5.0;
  Explorer explorer(config);
  const auto decide = [&](TimeNs now) {
    return tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, now);
  };
  TimeNs now = 0;
  PlanarPose places[2];
  int looks = 0;
  for (; looks < 200 && decide(now).kind == DecisionKind::goal; ++looks, now += kSecond) {
    const PlanarPose goal = decide(now).goal;
    CHECK_FALSE((looks > 1 && goal == places[0] && goal == places[1]));  // not three times in a row
    places[looks % 2] = goal;
    explorer.goal_reached();
  }
  const Decision end = decide(now);
  CHECK(end.kind != DecisionKind::goal);
  CHECK(end.left[LeftReason::fruitless] > 0);
  CHECK(end.left.open == 0);
  explorer.start_again();
  CHECK(decide(now + kSecond).kind != DecisionKind::goal);
}

TEST_CASE("starting again tries anew what could not be reached") {
  Run run("house");
  ExplorerConfig config;
  config.look_around_first = false;
  config.set_aside_s = 5.0;
  Explorer explorer(config);
  const auto decide = [&](TimeNs now) {
    return tests::decide_at_once(explorer, run.sim->ground(), run.sim->cost(), {}, run.start, now);
  };
  const Decision first = decide(0);
  TimeNs now = kSecond;
  for (int goals = 0; goals < 2000 && decide(now).kind == DecisionKind::goal; ++goals, now += kSecond) {
    explorer.goal_failed(GoalFailure::no_path);
  }
  REQUIRE(decide(now).kind != DecisionKind::goal);
  explorer.start_again();
  const Decision again = decide(now + kSecond);
  CHECK(again.kind == DecisionKind::goal);
  CHECK(again.goal == first.goal);
}
