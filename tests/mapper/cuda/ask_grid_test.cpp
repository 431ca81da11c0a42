// SPDX-License-Identifier: Apache-2.0
// What is refused, and a card that lies; right answers: see tests/nav/distance_field_test.cpp.
#include "mapper/cuda/ask_grid.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "tests/support/fake_card.hpp"
#include "tests/support/faulty_card.hpp"
#include "tests/support/small_card.hpp"
#include "tests/support/small_helper.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

/// Every step costs 50, diagonal ones 71.
GridSpread plain_spread(std::int32_t columns, std::int32_t rows) {
  GridSpread spread{};
  spread.columns = columns;
  spread.rows = rows;
  spread.relief_cells = -1;
  spread.max_cost = 100'000;
  for (StepPrices& prices : spread.prices) {
    for (std::uint16_t& price : prices.straight) price = 50;
    for (std::uint16_t& price : prices.diagonal) price = 71;
  }
  return spread;
}

}  // namespace

TEST_CASE("a grid that does not fit, or has no start, is not asked about") {
  cuda::Emulated card = test::small_card(100, 1);
  std::vector<std::uint8_t> costs(100);
  std::vector<std::uint32_t> distances(100);
  CHECK(cuda::ask_grid(card, plain_spread(20, 5), costs, distances));
  CHECK(distances[19] == 19 * 50);
  CHECK(distances[20 * 4 + 10] == 4 * 71 + 6 * 50);
  CHECK_FALSE(cuda::ask_grid(card, plain_spread(20, 4), costs, distances));
  GridSpread outside = plain_spread(20, 5);
  outside.start_x = 20;
  CHECK_FALSE(cuda::ask_grid(card, outside, costs, distances));
  costs.resize(101);
  distances.resize(101);
  CHECK_FALSE(cuda::ask_grid(card, plain_spread(101, 1), costs, distances));
}

TEST_CASE("a helper answers about grids, refuses too large ones, and its lies are noticed") {
  const test::FakeCard driver(test::FakeDriver::works);
  test::SmallHelper helper(cuda::carried_kernels(), 64 * 64);
  REQUIRE(helper.started() == cuda::HelperState::ready);
  const std::vector<std::uint8_t> costs(64 * 64);
  std::vector<std::uint32_t> distances(costs.size());
  REQUIRE(cuda::ask_grid(*helper.get(), plain_spread(64, 64), costs, distances));
  CHECK(distances[64 * 63 + 63] == 63 * 71);
  GridSpread& asked = *helper->grid_question().spread;
  asked.columns = 65;  // beyond its room
  CHECK_FALSE(helper->spread_grid());
  asked.columns = -1;
  CHECK_FALSE(helper->spread_grid());
}

TEST_CASE("distances that cannot be are not taken") {
  const std::vector<std::uint8_t> costs(64);
  std::vector<std::uint32_t> distances(64);
  test::FaultyCard card(std::make_shared<cuda::Emulated>(test::small_card(64, 2)));
  CHECK(cuda::ask_grid(card, plain_spread(8, 8), costs, distances));
  card.spoil_distances = [](std::uint32_t* d) { d[0] = 1; };
  CHECK_FALSE(cuda::ask_grid(card, plain_spread(8, 8), costs, distances));
  card.spoil_distances = [](std::uint32_t* d) { d[9] = 100'001; };
  CHECK_FALSE(cuda::ask_grid(card, plain_spread(8, 8), costs, distances));
  card.spoil_distances = {};
  card.fails_to_answer = true;
  CHECK_FALSE(cuda::ask_grid(card, plain_spread(8, 8), costs, distances));
}
