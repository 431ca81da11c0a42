// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/helper/card_session.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/support/fake_card.hpp"
#include "tests/support/small_helper.hpp"

using namespace g3d;
using mapper::cuda::HelperState;

TEST_CASE("kernels that the driver refuses, and a card without enough memory, are reported") {
  const test::FakeCard card(test::FakeDriver::works);
  {
    test::SmallHelper helper("these are no kernels");
    CHECK(helper.started() == HelperState::failed);
    CHECK(helper->problem().find("the driver refuses the kernels") != std::string::npos);
  }
  setenv("FAKE_CUDA_BYTES", "100000", 1);
  test::SmallHelper helper;
  CHECK(helper.started() == HelperState::failed);
  CHECK(helper->problem().find("CUDA_ERROR_OUT_OF_MEMORY") != std::string::npos);
}

TEST_CASE("more parcels than there is room for are refused") {
  const test::FakeCard card(test::FakeDriver::works);
  test::SmallHelper helper;
  REQUIRE(helper.started() == HelperState::ready);
  CHECK(helper->import_blocks(0));
  CHECK_FALSE(helper->import_blocks(helper->room() + 1));
}
