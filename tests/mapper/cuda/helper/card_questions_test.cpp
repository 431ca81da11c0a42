// SPDX-License-Identifier: Apache-2.0
// What the helper's side refuses of questions; their answers: see helper_process_test.cpp.
#include <catch2/catch.hpp>

#include "tests/support/fake_card.hpp"
#include "tests/support/small_helper.hpp"

using namespace g3d;
using mapper::cuda::HelperState;

TEST_CASE("more questions than there is room for are refused, and none, and looks without an image") {
  const test::FakeCard card(test::FakeDriver::works);
  test::SmallHelper helper;
  REQUIRE(helper.started() == HelperState::ready);
  REQUIRE(helper->ray_room() == 64);
  REQUIRE(helper->look_room() == 2);
  helper->queries().rays[0] = {{0, 0, 0}, {1, 0, 0}, 1.0F, 1};
  CHECK(helper->cast_rays(1, 0.05F));
  CHECK(helper->queries().ray_hits[0].end == mapper::RayEnd::unknown);
  CHECK_FALSE(helper->cast_rays(0, 0.05F));
  CHECK_FALSE(helper->cast_rays(65, 0.05F));
  mapper::LookModel model{0.05F, 0.8F, 3.5F, 32, 24, 1};
  CHECK(helper->count_looks(2, model));
  CHECK_FALSE(helper->count_looks(3, model));
  mapper::ColumnTables tables{};
  CHECK_FALSE(helper->set_columns(tables));  // no cells
  tables.voxels_per_cell = 4;
  CHECK(helper->set_columns(tables));
  CHECK_FALSE(helper->read_columns(0));  // there was no frame
  model.stride_px = 0;
  CHECK_FALSE(helper->count_looks(1, model));
}
