// SPDX-License-Identifier: Apache-2.0
// Frames aligned through the helper process, with a driver that has no card: as the CPU aligns them, and what the
// helper's side refuses.
#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/fake_card.hpp"
#include "tests/support/same_alignment.hpp"
#include "tests/support/small_helper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

TEST_CASE("a helper aligns as the CPU does", "[mapper][align][cuda]") {
  const test::FakeCard card(test::FakeDriver::works);
  const hal::CameraModel camera = test::small_camera(80);
  align::AlignOptions options;
  options.surface.slots = 1U << 15;
  MapperConfig config;
  config.capacity = {1U << 13, 1U << 12, 1U << 12};
  config.backend = Backend::cuda;
  config.surface_slots = 1U << 15;
  config.card_patience_ns = 20'000'000'000;
  Mapper mapper(config, camera);
  REQUIRE(mapper.fit_card() != nullptr);
  align::Aligner by_card(options, camera, mapper.fit_card());
  align::Aligner by_cpu(options, camera);
  for (const bool looks_at_map : {false, true}) {
    hal::TimeNs stamp_ns = looks_at_map ? 10'000'000'000 : 0;
    for (auto& [frame, pose] : test::random_frames(camera, 3, 5)) {
      hal::Frame own = hal::make_frame(camera);
      std::copy_n(frame.depth.get(), camera.pixel_count(), own.depth.get());
      own.stamp_ns = stamp_ns += 100'000'000;
      const align::SeenSpace space(mapper.map());
      const auto expected = by_cpu.align(own, pose, looks_at_map ? &space : nullptr);
      const auto result = by_card.align(own, pose, looks_at_map ? &space : nullptr);
      CHECK(test::are_equal(result, expected));
      CHECK(test::are_equal(by_card.surfaces(), by_cpu.surfaces()));
      (void)mapper.integrate(own, result.T_world_camera);
    }
  }
  CHECK(by_cpu.surfaces().piece_count() > 100);
  CHECK(mapper.card().fits_on_card == 6);
  CHECK(mapper.card().fits_on_cpu == 0);
}

TEST_CASE("a helper refuses cells beyond its table, and steps beyond its state", "[mapper][align][cuda]") {
  const test::FakeCard card(test::FakeDriver::works);
  const test::SmallSetup small;
  cuda::HelperSetup setup = small.setup();
  setup.sizes.surface_slots = 64;
  std::string problem;
  const auto helper = cuda::HelperProcess::start(setup, problem);
  REQUIRE(helper->wait_started(20'000'000'000) == cuda::HelperState::ready);
  CHECK(helper->import_cells(0, 64));
  CHECK(helper->import_cells(60, 4));
  CHECK_FALSE(helper->import_cells(60, 5));
  CHECK_FALSE(helper->import_cells(65, 1));
  CHECK_FALSE(helper->import_cells(0, 0));
  CHECK_FALSE(helper->import_cells(0, helper->alignment().cell_room + 1));
  *helper->alignment().question = {};
  helper->alignment().question->fit.most_steps = cuda::kMostFitSteps + 1;
  CHECK((helper->begin_fit() && !helper->finish_fit()));
  helper->alignment().question->fit.most_steps = -1;
  CHECK((helper->begin_fit() && !helper->finish_fit()));
  helper->alignment().question->swept_end = 65;
  CHECK_FALSE(helper->add_samples());
}
