// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/stretch_recorder.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>

#include "hal/geometry.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

hal::Pose at(double x_m) { return hal::from_xyz_rpy(x_m, 0, 0, 0, 0, 0); }

BlockKey block(int number) { return block_of({32768 + 8 * number, 32768, 32768}); }

struct Recorded {
  VoxelMap view{Grid{0.05F}, {64, 64, 64}};
  Stretch stretch{view};

  /// A whole block of one code. Returns its slot.
  std::uint32_t write(int number, Rgbo code) {
    BlockValues values;
    values.fill(code);
    REQUIRE(view.write_block(block(number), values));
    return view.find(block(number));
  }
  [[nodiscard]] Rgbo copied(int number) const { return stretch.blocks.at(block(number) << kBlockShift); }
};

/// A patch of a wall one metre before the camera, seen well.
std::vector<align::DepthSample> wall() {
  std::vector<align::DepthSample> samples;
  for (int i = 0; i < 40; ++i) samples.push_back({{0.02F * static_cast<float>(i % 5), 0.01F, 1.0F}, {0, 0, -1}, 1.0F});
  return samples;
}

constexpr ChainOptions kNeverDue{.most_way_m = 1e9, .most_turn_rad = 1e9, .most_s = 1e9};

}  // namespace

TEST_CASE("a stretch has the blocks that have changed on it, as they are at its end", "[submaps]") {
  Recorded r;
  StretchRecorder recorder(r.view, {});
  r.write(0, 3);  // the place where the robot stands, known before the first frame
  const std::uint32_t one = r.write(1, 4);
  recorder.add_frame(1, at(0), std::array{one}, {}, false);
  r.write(0, 5);
  REQUIRE(recorder.take(r.stretch));
  CHECK(r.stretch.blocks.block_count() == 2);
  CHECK(r.copied(0) == 5);
  CHECK(r.copied(1) == 4);

  r.stretch.clear();
  const std::uint32_t two = r.write(2, 20);
  recorder.add_frame(2, at(0), std::array{two}, {}, false);
  r.write(2, 21);
  recorder.add_frame(3, at(0), std::array{two, two}, {}, false);
  const std::uint32_t three = r.write(3, 7);
  recorder.add_frame(4, at(0), std::array{three}, {}, false);
  r.view.erase_block(block(3));
  r.write(1, 9);  // nobody says that it has changed
  REQUIRE(recorder.take(r.stretch));
  CHECK(r.stretch.blocks.sorted_keys() == std::vector{block(2)});
  CHECK(r.copied(2) == 21);
  // It is a copy: the view may go on.
  r.write(2, 30);
  CHECK(r.copied(2) == 21);
}

TEST_CASE("colours go into a stretch as they are", "[submaps]") {
  Recorded r;
  StretchRecorder recorder(r.view, {});
  BlockValues values;
  values.fill(32);
  values[7] = make_rgbo(0, 0, 0, 20 | kHasColourBit);
  values[8] = make_rgbo(1, 2, 3, 21 | kHasColourBit);
  REQUIRE(r.view.write_block(block(0), values));
  recorder.add_frame(1, at(0), {}, {}, false);
  REQUIRE(recorder.take(r.stretch));
  BlockValues copied;
  REQUIRE(r.stretch.blocks.read_stored_block(block(0), copied));
  CHECK(copied == values);
}

TEST_CASE("a block is noted until a stretch has it", "[submaps]") {
  Recorded r;
  StretchRecorder recorder(r.view, {});
  const std::uint32_t zero = r.write(0, 3);
  CHECK(recorder.is_noted(zero));  // no stretch has it yet
  recorder.add_frame(1, at(0), {}, {}, false);
  CHECK(recorder.is_noted(zero));
  REQUIRE(recorder.take(r.stretch));
  CHECK_FALSE(recorder.is_noted(zero));

  r.stretch.clear();
  const std::uint32_t one = r.write(1, 3);
  recorder.add_frame(2, at(0), std::array{one}, {}, false);
  CHECK(recorder.is_noted(one));
  CHECK_FALSE(recorder.is_noted(zero));
  REQUIRE(recorder.take(r.stretch));
  CHECK_FALSE(recorder.is_noted(one));
  recorder.add_frame(3, at(0), std::array{zero}, {}, false);
  CHECK(recorder.is_noted(zero));
}

TEST_CASE("a stretch has the surfaces of its own frames, in the world", "[submaps]") {
  Recorded r;
  StretchRecorder recorder(r.view, {});
  const auto samples = wall();
  recorder.add_frame(1, at(2.0), {}, samples, false);
  REQUIRE(recorder.take(r.stretch));
  std::size_t pieces = 0;
  r.stretch.surfaces->for_each([&](const align::SurfacePiece& piece, float /*weight*/) {
    ++pieces;
    CHECK(piece.point_m[2] == Approx(1.0F).margin(0.002));
    CHECK(piece.point_m[0] >= 1.99F);
  });
  CHECK(pieces > 0);

  r.stretch.clear();
  recorder.add_frame(2, at(2.0), {}, {}, false);
  REQUIRE(recorder.take(r.stretch));
  CHECK(r.stretch.surfaces->piece_count() == 0);
}

TEST_CASE("the anchor of a stretch is the camera half-way, and the way to it is from the anchor before", "[submaps]") {
  Recorded r;
  StretchRecorder recorder(r.view, kNeverDue);
  constexpr hal::TimeNs kSecond_ns = 1'000'000'000;
  for (int i = 0; i <= 4; ++i) recorder.add_frame(i * kSecond_ns, at(i), {}, {}, i == 2);
  REQUIRE(recorder.take(r.stretch));
  CHECK(r.stretch.first_ns == 0);
  CHECK(r.stretch.last_ns == 4 * kSecond_ns);
  CHECK(r.stretch.anchor_ns == 2 * kSecond_ns);
  CHECK(r.stretch.T_world_anchor.translation_m[0] == 2.0);
  CHECK(r.stretch.way_m == Approx(2.0));
  CHECK(r.stretch.turn_rad == 0.0);
  CHECK(r.stretch.held_s == Approx(1.0));

  // From 2 m over the end at 4 m to half of what is left to 7 m.
  r.stretch.clear();
  for (int i = 5; i <= 7; ++i) recorder.add_frame(i * kSecond_ns, at(i), {}, {}, true);
  REQUIRE(recorder.take(r.stretch));
  CHECK(r.stretch.anchor_ns == 6 * kSecond_ns);
  CHECK(r.stretch.way_m == Approx(4.0));
  CHECK(r.stretch.held_s == Approx(2.0));

  r.stretch.clear();
  recorder.add_frame(8 * kSecond_ns, hal::from_xyz_rpy(7, 0, 0, 0, 0, 0.3), {}, {}, false);
  REQUIRE(recorder.take(r.stretch));
  CHECK(r.stretch.first_ns == r.stretch.last_ns);
  CHECK(r.stretch.way_m == Approx(1.0));
  CHECK(r.stretch.turn_rad == Approx(0.3).epsilon(0.01));
  CHECK(r.stretch.held_s == Approx(1.0));
}

TEST_CASE("there is no stretch without a frame", "[submaps]") {
  Recorded r;
  StretchRecorder recorder(r.view, {});
  r.write(0, 3);
  CHECK(recorder.is_empty());
  CHECK_FALSE(recorder.take(r.stretch));
  recorder.add_frame(5, at(1), {}, {}, false);
  CHECK_FALSE(recorder.is_empty());
  REQUIRE(recorder.take(r.stretch));
  CHECK(recorder.is_empty());
  CHECK_FALSE(recorder.take(r.stretch));
  CHECK(r.stretch.last_ns == 5);
  CHECK(r.stretch.blocks.block_count() == 1);
  r.stretch.clear();
  CHECK(r.stretch.blocks.block_count() == 0);
}

TEST_CASE("a stretch of more frames than it remembers still ends where the last one was", "[submaps]") {
  Recorded r;
  StretchRecorder recorder(r.view, kNeverDue);
  const std::uint32_t slot = r.write(0, 3);
  const int frames = GENERATE(8192, 8193, 30'000);
  for (int i = 0; i < frames; ++i) CHECK_FALSE(recorder.add_frame(1 + i, at(0.001 * i), std::array{slot}, {}, false));
  REQUIRE(recorder.take(r.stretch));
  CHECK(r.stretch.first_ns == 1);
  CHECK(r.stretch.last_ns == frames);
  CHECK(r.stretch.blocks.block_count() == 1);
  // Half-way; or the last one, where that is among those that it does not remember.
  const int anchor = frames < 16'384 ? frames / 2 : frames;
  CHECK(std::abs(r.stretch.anchor_ns - anchor) <= 2);
  const auto anchor_m = 0.001 * static_cast<double>(r.stretch.anchor_ns - 1);
  CHECK(r.stretch.T_world_anchor.translation_m[0] == Approx(anchor_m));
  CHECK(r.stretch.way_m == Approx(anchor_m));

  r.stretch.clear();
  recorder.add_frame(frames + 1, at(0.001 * frames), {}, {}, false);
  REQUIRE(recorder.take(r.stretch));
  CHECK(r.stretch.way_m == Approx(0.001 * frames - anchor_m));
}
