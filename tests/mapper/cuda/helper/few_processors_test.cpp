// SPDX-License-Identifier: Apache-2.0
// A card without a card has two multiprocessors and gives them out by twos, or singly if nobody wants clusters. It
// takes launches into the confined stream alone once there is one.
#include "mapper/cuda/helper/few_processors.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <string>

#include "mapper/cuda/helper_process.hpp"
#include "tests/support/fake_card.hpp"
#include "tests/support/small_helper.hpp"

using namespace g3d;
using namespace g3d::mapper::cuda;

namespace {

/// A helper that was told to keep to so many.
std::unique_ptr<HelperProcess> started(std::uint32_t processors) {
  const test::SmallSetup small;
  HelperSetup setup = small.setup();
  setup.processors = processors;
  std::string problem;
  auto helper = HelperProcess::start(setup, problem);
  REQUIRE(helper != nullptr);
  REQUIRE(helper->wait_started(20'000'000'000) == HelperState::ready);
  return helper;
}

}  // namespace

TEST_CASE("a helper keeps to as few multiprocessors as it is told") {
  const test::FakeCard card(test::FakeDriver::works);
  for (const std::uint32_t wanted : {0U, 1U, 2U}) {
    INFO(wanted << " wanted");
    const auto helper = started(wanted);
    CHECK(helper->processors() == (wanted == 1 ? 1 : 2));
    CHECK(helper->note().empty());
    CHECK(helper->import_blocks(0));  // launched where it should be
  }
}

TEST_CASE(
    "more multiprocessors than the card has, and a driver that does not share it out: the whole card, and a word") {
  const test::FakeCard card(test::FakeDriver::works);
  {
    const auto helper = started(3);
    CHECK(helper->processors() == 2);
    CHECK(helper->note() == "the card has no such share");
    CHECK(helper->import_blocks(0));
  }
  setenv("FAKE_CUDA_NO_SHARES", "1", 1);
  const auto helper = started(1);
  CHECK(helper->processors() == 2);
  CHECK(helper->note() == "cuDeviceGetDevResource: CUDA_ERROR_NOT_SUPPORTED");
  CHECK(helper->import_blocks(0));
}
