// SPDX-License-Identifier: Apache-2.0
#include "nav/team_cost.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;
using nav::CellGrid;
using nav::TeamCost;

TEST_CASE("bodies that stand close the costs around them and leave no trace", "[nav][team]") {
  CellGrid<std::uint8_t> cost(0.05, 0.0, 0.0, 80, 80, nav::kFreeCost);
  for (int y = 0; y < 80; ++y) cost.at({60, y}) = nav::kLethalCost;
  for (int y = 0; y < 80; ++y) cost.at({61, y}) = nav::kUnknownCost;
  TeamCost team(cost);
  CHECK(team.empty());
  std::array<TeamCost::Body, 2> bodies{{{1.0, 1.0, 0.42}, {2.9, 2.0, 0.42}}};
  team.stand(cost, bodies);
  CHECK_FALSE(team.empty());
  const auto at = [&](double x_m, double y_m) { return team.cost().at(team.cost().cell_of(x_m, y_m)); };
  CHECK(at(1.0, 1.0) == nav::kInscribedCost);
  CHECK(at(1.36, 1.0) == nav::kInscribedCost);
  CHECK(at(1.52, 1.0) > nav::kFreeCost);
  CHECK(at(1.52, 1.0) < nav::kInscribedCost);
  CHECK(at(1.72, 1.0) == nav::kFreeCost);
  CHECK(at(3.02, 2.0) == nav::kLethalCost);  // a wall stays one
  CHECK(at(3.07, 3.9) == nav::kUnknownCost);
  // The floor changes beneath.
  cost.at(cost.cell_of(0.5, 3.0)) = nav::kLethalCost;
  cost.at(cost.cell_of(1.0, 1.0)) = 7;
  const std::vector<std::uint32_t> changed{static_cast<std::uint32_t>(cost.index(cost.cell_of(0.5, 3.0))),
                                           static_cast<std::uint32_t>(cost.index(cost.cell_of(1.0, 1.0)))};
  team.note_changed(cost, changed);
  CHECK(at(0.5, 3.0) == nav::kLethalCost);
  CHECK(at(1.0, 1.0) == nav::kInscribedCost);
  // One goes on, then both.
  team.stand(cost, std::span(bodies).subspan(1));
  CHECK(at(1.0, 1.0) == 7);
  CHECK(at(2.9, 2.0) == nav::kInscribedCost);
  team.stand(cost, {});
  CHECK(team.empty());
  CHECK(team.cost().cells == cost.cells);
}
