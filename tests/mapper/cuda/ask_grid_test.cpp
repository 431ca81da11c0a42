// SPDX-License-Identifier: Apache-2.0
// What is refused, and a card that lies; right answers: see tests/nav/distance_field_test.cpp.
#include "mapper/cuda/ask_grid.hpp"

#include <catch2/catch.hpp>
#include <functional>
#include <vector>

#include "tests/support/fake_card.hpp"
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

namespace {

/// The map's side is nobody's concern here.
class LyingCard final : public cuda::Card {
 public:
  explicit LyingCard(std::function<void(std::uint32_t*)> lie) : lie_(std::move(lie)) {}
  cuda::FrameInput& input() override { return good_.input(); }
  std::uint16_t* depth() override { return good_.depth(); }
  std::uint8_t* rgb() override { return good_.rgb(); }
  const cuda::Parcels& parcels() override { return good_.parcels(); }
  std::uint32_t room() const override { return good_.room(); }
  const cuda::Classes& classes() override { return good_.classes(); }
  std::uint32_t class_room() const override { return good_.class_room(); }
  bool import_blocks(std::uint32_t) override { return false; }
  bool begin_frame() override { return false; }
  bool finish_frame(cuda::FrameCounters&) override { return false; }
  bool send_blocks(std::uint32_t) override { return false; }
  bool set_columns(const ColumnTables&) override { return false; }
  bool read_columns(std::uint32_t) override { return false; }
  const cuda::Columns& columns() override { return good_.columns(); }
  std::uint32_t column_room() const override { return good_.column_room(); }
  const cuda::Queries& queries() override { return good_.queries(); }
  std::uint32_t ray_room() const override { return good_.ray_room(); }
  std::uint32_t look_room() const override { return good_.look_room(); }
  bool cast_rays(std::uint32_t, float) override { return false; }
  bool count_looks(std::uint32_t, const LookModel&) override { return false; }
  const cuda::GridQuestion& grid_question() override { return good_.grid_question(); }
  std::uint32_t grid_room() const override { return good_.grid_room(); }
  bool spread_grid() override {
    const bool done = good_.spread_grid();
    if (lie_) lie_(good_.grid_question().distances);
    return done;
  }

 private:
  cuda::Emulated good_ = test::small_card(64, 2);
  std::function<void(std::uint32_t*)> lie_;
};

}  // namespace

TEST_CASE("distances that cannot be are not taken") {
  const std::vector<std::uint8_t> costs(64);
  std::vector<std::uint32_t> distances(64);
  LyingCard honest({});
  CHECK(cuda::ask_grid(honest, plain_spread(8, 8), costs, distances));
  LyingCard away([](std::uint32_t* d) { d[0] = 1; });
  CHECK_FALSE(cuda::ask_grid(away, plain_spread(8, 8), costs, distances));
  LyingCard beyond([](std::uint32_t* d) { d[9] = 100'001; });
  CHECK_FALSE(cuda::ask_grid(beyond, plain_spread(8, 8), costs, distances));
}
