// SPDX-License-Identifier: Apache-2.0
// A card without a card has two multiprocessors and gives them out by twos, or singly if nobody wants clusters. It
// takes launches into the confined stream alone once there is one.
#include "mapper/cuda/helper/few_processors.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "mapper/cuda/carried.hpp"
#include "mapper/cuda/helper_process.hpp"
#include "tests/support/fake_card.hpp"

using namespace g3d;
using namespace g3d::mapper::cuda;

namespace {

MemorySizes small_sizes() {
  MemorySizes sizes{};
  sizes.width_px = 32;
  sizes.height_px = 24;
  sizes.box_blocks = 512;
  sizes.blocks = 256;
  sizes.planes = 128;
  sizes.bricks = 128;
  return sizes;
}

/// A helper that was told to keep to so many.
std::unique_ptr<HelperProcess> started(std::uint32_t processors) {
  const std::vector<float> slopes(32, 0.0F);
  const std::vector<std::uint16_t> mask(32 * 24, 3000);
  std::string problem;
  auto helper = HelperProcess::start({.program = carried_helper(),
                                      .kernels = carried_kernels(),
                                      .sizes = small_sizes(),
                                      .room = 16,
                                      .column_slope = slopes,
                                      .row_slope = std::span(slopes).first(24),
                                      .mask = mask,
                                      .processors = processors,
                                      .patience_ns = 20'000'000'000},
                                     problem);
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
