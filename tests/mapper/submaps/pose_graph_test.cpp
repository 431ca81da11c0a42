// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/pose_graph.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "mapper/align/pose_step.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

/// Around a ring of `count` places, 2 pi r long.
std::vector<hal::Pose> ring(std::size_t count, double radius_m) {
  std::vector<hal::Pose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    poses.push_back(hal::from_xyz_rpy(radius_m * std::sin(angle), radius_m * (1.0 - std::cos(angle)), 0, 0, 0, angle));
  }
  return poses;
}

/// The nodes as odometry with a bias has them, and edges as it measured them.
PoseGraph drifting(const std::vector<hal::Pose>& truth, double bias_rad) {
  PoseGraph graph;
  hal::Pose at = truth.front();
  graph.add_node(at);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    hal::Pose step = hal::compose(hal::inverse(truth[i - 1]), truth[i]);
    step = hal::compose(step, hal::from_xyz_rpy(0.01, 0.0, 0.0, 0.0, 0.0, bias_rad));
    at = hal::compose(at, step);
    const std::uint32_t node = graph.add_node(at);
    graph.add_edge({node - 1, node, step, information_of({}), false});
  }
  return graph;
}

double worst_m(const PoseGraph& graph, const std::vector<hal::Pose>& truth) {
  double worst = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    worst = std::max(worst, align::shift_of(align::difference(truth[i], graph.nodes()[i])));
  }
  return worst;
}

GraphEdge loop(const std::vector<hal::Pose>& truth, std::uint32_t from, std::uint32_t to) {
  return {from, to, hal::compose(hal::inverse(truth[from]), truth[to]), information_of({0.005, 0.005, 0.002, 0.002}),
          true};
}

}  // namespace

TEST_CASE("nodes that agree with their edges stay, whatever their turns") {
  tests::Random random(3);
  PoseGraph graph;
  std::vector<hal::Pose> poses;
  for (int i = 0; i < 12; ++i) {
    poses.push_back(hal::from_xyz_rpy(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-2, 2),
                                      random.uniform(-3, 3), random.uniform(-1, 1), random.uniform(-3, 3)));
    graph.add_node(poses.back());
    for (int j = 0; j < i; j += 3) {
      graph.add_edge({static_cast<std::uint32_t>(j), static_cast<std::uint32_t>(i),
                      hal::compose(hal::inverse(poses[static_cast<std::size_t>(j)]), poses.back()), information_of({}),
                      j > 3});
    }
  }
  const GraphReport report = graph.optimise();
  CHECK(report.solved);
  CHECK(report.cost_after < 1e-12);
  CHECK(worst_m(graph, poses) < 1e-9);
}

TEST_CASE("nodes in any frame are brought to where exact edges have them") {
  // Full turns in space: the derivatives have to be right, or this takes many steps or ends elsewhere.
  tests::Random random(5);
  PoseGraph graph;
  std::vector<hal::Pose> poses;
  for (std::uint32_t i = 0; i < 20; ++i) {
    poses.push_back(hal::from_xyz_rpy(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-2, 2),
                                      random.uniform(-3, 3), random.uniform(-1, 1), random.uniform(-3, 3)));
    const align::Vector6 off{random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                             random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)};
    graph.add_node(i == 0 ? poses[0] : align::moved(poses.back(), off));
    for (std::uint32_t j = i > 4 ? i - 4 : 0; j < i; ++j) {
      graph.add_edge({j, i, hal::compose(hal::inverse(poses[j]), poses[i]), information_of({}), false});
    }
  }
  const GraphReport report = graph.optimise();
  CHECK(report.solved);
  CHECK(report.steps <= 8);
  CHECK(report.cost_before > 1000.0);
  CHECK(worst_m(graph, poses) < 1e-6);
}

TEST_CASE("a loop that is recognised takes out most of what odometry had gathered") {
  const auto truth = ring(24, 8.0);
  PoseGraph graph = drifting(truth, 0.004);  // of one standard deviation, always to the same side
  const double before_m = worst_m(graph, truth);
  CHECK(before_m > 0.5);
  graph.add_edge(loop(truth, 0, 23));
  const GraphReport report = graph.optimise();
  CHECK(report.solved);
  CHECK(graph.belief_in(graph.edges().back()) > 0.9);
  CHECK(worst_m(graph, truth) < 0.2 * before_m);
  CHECK(align::shift_of(align::difference(graph.nodes()[0], truth[0])) == 0.0);
}

TEST_CASE("one false loop among true ones bends nothing, and is not believed") {
  const auto truth = ring(24, 8.0);
  PoseGraph sound = drifting(truth, 0.002);
  PoseGraph fooled = drifting(truth, 0.002);
  for (PoseGraph* graph : {&sound, &fooled}) {
    for (std::uint32_t i = 0; i < 4; ++i) graph->add_edge(loop(truth, i, 20 + i));
  }
  GraphEdge wrong = loop(truth, 2, 12);
  wrong.T_from_to.translation_m[0] += 3.0;
  fooled.add_edge(wrong);
  CHECK(sound.optimise().solved);
  CHECK(fooled.optimise().solved);
  CHECK(fooled.belief_in(fooled.edges().back()) < 0.01);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    CHECK(align::shift_of(align::difference(sound.nodes()[i], fooled.nodes()[i])) < 0.05);
  }
}

TEST_CASE("a graph without edges, or with a single node, is left alone") {
  PoseGraph graph;
  CHECK(graph.optimise().solved);
  graph.add_node({});
  graph.add_node(hal::from_xyz_rpy(1, 2, 3, 0, 0, 1));
  const GraphReport report = graph.optimise();
  CHECK(report.steps == 0);
  CHECK(graph.nodes()[1].translation_m[1] == 2.0);
}

TEST_CASE("five hundred nodes and a hundred loops take a fraction of a second", "[slow]") {
  const auto truth = ring(500, 40.0);
  PoseGraph graph = drifting(truth, 0.0005);
  for (std::uint32_t i = 0; i < 100; ++i) graph.add_edge(loop(truth, 2 * i, 500 - 1 - i));
  const double before_m = worst_m(graph, truth);
  const GraphReport report = graph.optimise();
  CHECK(report.solved);
  CHECK(report.steps <= 100);
  CHECK(worst_m(graph, truth) < 0.3 * before_m);
}

TEST_CASE("a node that is joined to the one before leaves a graph that stands and costs the same", "[submaps]") {
  PoseGraph graph;
  const auto at = [](double x_m, double y_m, double yaw) { return hal::from_xyz_rpy(x_m, y_m, 0, 0, 0, yaw); };
  const std::vector<hal::Pose> nodes{at(0, 0, 0), at(1, 0.2, 0.3), at(2, 0.1, 1.0), at(2, 1.5, 2.0), at(0.3, 1, 3.0)};
  for (const hal::Pose& node : nodes) graph.add_node(node);
  const auto measured = [&](std::uint32_t from, std::uint32_t to, const hal::Pose& off) {
    return hal::compose(hal::compose(hal::inverse(nodes[from]), nodes[to]), off);
  };
  const align::Matrix6 way = information_of({});
  graph.add_edge({0, 1, measured(0, 1, at(0.01, 0.02, 0.01)), way, false});
  graph.add_edge({1, 2, measured(1, 2, at(0.02, 0, 0.01)), way, false});
  graph.add_edge({2, 3, measured(2, 3, at(0.01, -0.03, 0.02)), way, false});
  graph.add_edge({3, 4, measured(3, 4, at(0.0, 0.02, -0.01)), way, false});
  graph.add_edge({0, 2, measured(0, 2, at(0.02, 0.01, -0.02)), way, true});
  graph.add_edge({2, 4, measured(2, 4, at(-0.02, 0.01, 0.02)), way, true});
  std::vector<double> squares;
  for (const GraphEdge& edge : graph.edges()) squares.push_back(graph.square_of(edge));

  graph.join(1, hal::compose(hal::inverse(nodes[2]), nodes[1]));
  REQUIRE(graph.nodes().size() == 4);
  CHECK(graph.nodes()[2].translation_m == nodes[3].translation_m);
  REQUIRE(graph.edges().size() == 5);  // what was measured between the two is gone
  squares.erase(squares.begin() + 1);
  for (std::size_t i = 0; i < squares.size(); ++i) {
    CHECK(graph.edges()[i].from < 4);
    CHECK(graph.square_of(graph.edges()[i]) == Approx(squares[i]).epsilon(1e-3));
  }
  CHECK(graph.optimise().solved);
}
