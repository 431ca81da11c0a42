// SPDX-License-Identifier: Apache-2.0
// Frames aligned by kernels in random order, against the CPU: the same poses and the same surfaces, bit by bit; and a
// card that fails or lies changes neither.
#include "mapper/cuda/align_twin.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "hal/sim/world_file.hpp"
#include "mapper/align/aligner.hpp"
#include "tests/support/emulated_mapper.hpp"
#include "tests/support/faulty_card.hpp"
#include "tests/support/same_alignment.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

constexpr std::uint32_t kSlots = 1U << 17;
const hal::CameraModel kCamera = hal::scaled_kinect(80, 60);

/// What Mapper gives an aligner, over an emulated card that may be told to fail.
struct EmulatedFit final : align::FitCard {
  explicit EmulatedFit(test::EmulatedMapper& on) : mapper(on) { new_card(1); }
  void new_card(std::uint64_t seed) {
    mapper.new_card(seed);
    card = std::make_unique<test::FaultyCard>(mapper.card);
    twin.forget_card();
  }
  bool fit(const hal::Frame& frame, const align::SampleShape& shape, const align::SurfaceMap& mirror,
           const align::FitQuestion& question, align::CardFit& fitted) override {
    return answered(card != nullptr && cuda::AlignTwin::can(*card, shape, mirror, question) &&
                    twin.fit(*card, frame, shape, mirror, question, fitted));
  }
  bool add(const hal::RigidTransform& T, hal::TimeNs stamp_ns, bool looks_at_map, align::SurfaceMap& mirror) override {
    return answered(card != nullptr && (!looks_at_map || mapper.twin.send_changes()) &&
                    twin.add(*card, T, stamp_ns, looks_at_map, mapper.config.resolution_m, mirror));
  }
  void forget_surfaces() override { twin.forget_card(); }
  bool answered(bool by_card) {
    if (!by_card) card.reset();
    ++(by_card ? answers : refusals);
    return by_card;
  }
  test::EmulatedMapper& mapper;
  std::unique_ptr<test::FaultyCard> card;
  cuda::AlignTwin twin;
  int answers = 0;
  int refusals = 0;
};

/// A robot turns in a furnished room while somebody walks by; its odometry slips.
struct Drive {
  explicit Drive(align::AlignOptions align_options = options())
      : emulated(config(), kCamera, 1),
        fit(emulated),
        by_card(align_options, kCamera, &fit),
        by_cpu(align_options, kCamera) {}
  static align::AlignOptions options() {
    align::AlignOptions o;
    o.surface.slots = kSlots;
    return o;
  }
  static MapperConfig config() {
    MapperConfig c;
    c.capacity = {1U << 14, 1U << 13, 1U << 13};
    c.surface_slots = kSlots;
    return c;
  }
  void step(bool looks_at_map) {
    const double walks_m = 0.06 * number;
    auto world = hal::parse_world(
        fmt::format(
            "room 0 0 0 6 5 2.5 0.1\nbox 1.5 1 0 0.6 0.8 1\nbox -1 -1.2 0 0.5 0.5 0.9\nbox {} 0.4 0 0.4 0.4 1.7\n",
            2.2 - walks_m),
        "test.world");
    hal::SimRenderer renderer(std::move(world).value(), {.camera = kCamera});
    hal::Frame frame = hal::make_frame(kCamera);
    const double turn_rad = 0.05 * number;
    const hal::Pose truth =
        hal::compose(hal::from_xyz_rpy(0.02 * number, 0, 0, 0, 0, turn_rad), hal::forward_camera(0.5));
    const hal::Pose odometry = hal::compose(
        hal::from_xyz_rpy(0.0215 * number, 0.001 * number, 0, 0, 0, 1.04 * turn_rad), hal::forward_camera(0.5));
    renderer.render(truth, number * 100'000'000LL, static_cast<std::uint64_t>(number), frame);
    frame.stamp_ns = number * 100'000'000LL;
    ++number;
    const align::SeenSpace space(emulated.map);
    const align::AlignResult expected = by_cpu.align(frame, odometry, looks_at_map ? &space : nullptr);
    const align::AlignResult result = by_card.align(frame, odometry, looks_at_map ? &space : nullptr);
    INFO("frame " << number);
    CHECK(test::are_equal(result, expected));
    outcomes[static_cast<std::size_t>(result.outcome)] += 1;
    CHECK(test::are_equal(by_card.surfaces(), by_cpu.surfaces()));
    if (fit.card != nullptr && emulated.twin.has_card()) {
      (void)emulated.integrate(frame, result.T_world_camera);
    }
  }
  test::EmulatedMapper emulated;
  EmulatedFit fit;
  align::Aligner by_card;
  align::Aligner by_cpu;
  int number = 0;
  std::array<int, 16> outcomes{};
};

}  // namespace

TEST_CASE("kernels in random order align as the CPU does, and leave the same surfaces", "[mapper][align][cuda]") {
  Drive drive;
  for (int i = 0; i < 12; ++i) drive.step(false);
  CHECK(drive.fit.answers == 24);
  CHECK(drive.outcomes[static_cast<std::size_t>(align::AlignOutcome::aligned)] > 8);
}

TEST_CASE("kernels find out what moves as the CPU does", "[mapper][align][cuda][slow]") {
  Drive drive;
  for (int i = 0; i < 40; ++i) drive.step(true);
  CHECK(drive.by_card.surfaces().unsteady_count() > 0);
  CHECK(drive.by_card.surfaces().next_swept().first != 0);
  CHECK(drive.fit.answers == 80);
}

TEST_CASE("an aligner goes on by itself when its card is lost, and with the next one", "[mapper][align][cuda]") {
  Drive drive;
  for (int i = 0; i < 3; ++i) drive.step(false);
  drive.fit.card->fails_to_answer = true;
  for (int i = 0; i < 3; ++i) drive.step(false);
  CHECK(drive.fit.card == nullptr);
  drive.fit.new_card(7);
  const int before = drive.fit.answers;
  for (int i = 0; i < 3; ++i) drive.step(false);
  CHECK(drive.fit.answers == before + 6);
}

TEST_CASE("a card that lies about a fit or its cells is lost, and nothing of it is taken", "[mapper][align][cuda]") {
  using Spoil = std::function<void(const cuda::Alignment&)>;
  const std::vector<Spoil> lies{
      [](const cuda::Alignment& a) { a.state->chosen = cuda::kMostChosen + 1; },
      [](const cuda::Alignment& a) { a.state->steps = 9; },
      [](const cuda::Alignment& a) { a.state->sums[0].matched = -1; },
      [](const cuda::Alignment& a) { a.state->sums[a.state->steps].square = -1; },
      [](const cuda::Alignment& a) {
        a.state->pose.rotation_xyzw = {0, 0, 0, 2};
      },
      [](const cuda::Alignment& a) { a.state->pose.translation_m[0] = std::nan(""); },
      [](const cuda::Alignment& a) { a.state->touched = a.state->touched != 0 ? a.cell_room + 1 : 0; },
      [](const cuda::Alignment& a) { a.cells[0].key = 0; },
      [](const cuda::Alignment& a) { a.cells[0].weight = 0; },
      [](const cuda::Alignment& a) { a.cells[0].place[1] = -1; },
      [](const cuda::Alignment& a) { a.cells[0].normal[2] = 1 << 30; },
      [](const cuda::Alignment& a) { a.cells[0].frame = 1000; },
  };
  for (std::size_t i = 0; i < lies.size(); ++i) {
    CAPTURE(i);
    Drive drive;
    for (int frame = 0; frame < 2; ++frame) drive.step(false);
    drive.fit.card->spoil_alignment = lies[i];
    drive.step(false);
    CHECK(drive.fit.card == nullptr);
    drive.step(false);
  }
}

TEST_CASE("a full table refuses the same samples on both sides", "[mapper][align][cuda]") {
  align::SurfaceOptions options;
  options.slots = kSlots;
  align::SurfaceMap of_card(options);
  align::SurfaceMap of_cpu(options);
  std::vector<align::DepthSample> many;
  for (int i = 0; many.size() < kSlots * 3 / 4; ++i) {
    const auto along = [](int k) { return 0.08F * static_cast<float>(k) + 0.04F; };
    many.push_back({{along(i % 400), along(i / 400), -5.0F}, {0, 0, -1}, 0.5F});
  }
  of_card.add(many, {});
  of_cpu.add(many, {});
  REQUIRE_FALSE(of_card.takes_new_cells());

  test::EmulatedMapper emulated(Drive::config(), kCamera, 1);
  cuda::AlignTwin twin;
  align::DepthSamples samples(kCamera);
  hal::SimRenderer renderer(hal::parse_world("room 0 0 0 6 5 2.5 0.1\n", "test.world").value(), {.camera = kCamera});
  hal::Frame frame = hal::make_frame(kCamera);
  const hal::Pose pose = hal::forward_camera(0.5);
  renderer.render(pose, 0, 1, frame);
  samples.compute(frame.depth.get());
  align::FitQuestion question;
  question.predicted = pose;
  align::CardFit fitted;
  REQUIRE(twin.fit(*emulated.card, frame, samples.shape(), of_card, question, fitted));
  CHECK(fitted.chosen == samples.chosen().size());
  REQUIRE(twin.add(*emulated.card, hal::to_transform(pose), 5, false, 0.05F, of_card));
  of_cpu.add(samples.all(), hal::to_transform(pose), 5);
  CHECK(of_cpu.refused() > 100);
  CHECK(test::are_equal(of_card, of_cpu));
}

TEST_CASE("a table that fills is made room in, and the card has it anew", "[mapper][align][cuda][slow]") {
  align::AlignOptions options = Drive::options();
  options.surface.rule.cell_m = 0.006F;
  Drive drive(options);
  for (int i = 0; i < 60; ++i) drive.step(false);
  CHECK(drive.by_card.report().forgotten_pieces > 1000);
  CHECK(drive.by_card.report().forgotten_pieces == drive.by_cpu.report().forgotten_pieces);
  CHECK(drive.fit.answers == 120);
}

TEST_CASE("what a card has no room for is left to the CPU", "[mapper][align][cuda]") {
  align::AlignOptions options = Drive::options();
  options.samples.most_chosen = cuda::kMostChosen + 1;
  Drive many(options);
  many.step(false);
  CHECK(many.fit.answers == 0);
  options = Drive::options();
  options.surface.slots = kSlots / 2;
  Drive other(options);
  other.step(false);
  CHECK(other.fit.answers == 0);
}
