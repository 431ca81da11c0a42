// SPDX-License-Identifier: Apache-2.0
// What a helper says of drivers that are not there or not whole. It is a program of its own, so it is asked as one.
#include "mapper/cuda/helper/driver.hpp"

#include <catch2/catch.hpp>

#include "tests/support/fake_card.hpp"
#include "tests/support/small_helper.hpp"

using namespace g3d;

TEST_CASE("a missing driver and one that lacks functions are told apart, by name") {
  for (const auto& [driver, missing] : {std::pair{test::FakeDriver::not_there, "libcuda.so.1 is missing"},
                                        std::pair{test::FakeDriver::lacks_functions, "cuInit is missing"}}) {
    const test::FakeCard card(driver);
    test::SmallHelper helper;
    CHECK(helper.started() == mapper::cuda::HelperState::failed);
    CHECK(helper->problem().find("no NVIDIA driver here") != std::string::npos);
    CHECK(helper->problem().find(missing) != std::string::npos);
  }
}
