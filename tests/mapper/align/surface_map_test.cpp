// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/surface_map.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

#include "hal/sim/seeded_random.hpp"

using namespace g3d;
using namespace g3d::mapper::align;

namespace {

/// Samples of the wall x = x_m, one metre square, that faces `side` along x.
std::vector<DepthSample> wall(float x_m, float side, int count, double sigma_m, std::uint64_t seed) {
  hal::SeededRandom random(seed);
  std::vector<DepthSample> samples;
  for (int i = 0; i < count; ++i) {
    const auto y = static_cast<float>(random.uniform());
    const auto z = static_cast<float>(random.uniform());
    samples.push_back({{x_m + static_cast<float>(sigma_m * random.gaussian()), y, z}, {side, 0, 0}, 0.1F});
  }
  return samples;
}

SurfaceOptions small() { return {.rule = {.cell_m = 0.05F}, .slots = 1U << 14}; }

}  // namespace

TEST_CASE("a piece lies on the wall to a fraction of its cell", "[mapper][align]") {
  SurfaceMap map(small());
  for (int frame = 0; frame < 20; ++frame) {
    map.add(wall(2.013F, -1.0F, 4000, 0.004, static_cast<std::uint64_t>(frame)), {});
  }
  std::size_t found = 0;
  for (float y = 0.1F; y < 0.9F; y += 0.03F) {
    const auto piece = map.find({2.03F, y, 0.5F}, {-1, 0, 0});
    REQUIRE(piece);
    CHECK(std::abs(piece->point_m[0] - 2.013F) < 0.001F);
    CHECK(piece->normal[0] < -0.999F);
    ++found;
  }
  CHECK(found > 20);
}

TEST_CASE("a point finds the surface one cell before or behind it, and no farther", "[mapper][align]") {
  SurfaceMap map(small());
  map.add(wall(2.013F, -1.0F, 4000, 0.0, 1), {});
  CHECK(map.find({2.06F, 0.5F, 0.5F}, {-1, 0, 0}));
  CHECK(map.find({1.96F, 0.5F, 0.5F}, {-1, 0, 0}));
  CHECK_FALSE(map.find({2.12F, 0.5F, 0.5F}, {-1, 0, 0}));
  CHECK_FALSE(map.find({1.90F, 0.5F, 0.5F}, {-1, 0, 0}));
  CHECK_FALSE(map.find({2.013F, 2.5F, 0.5F}, {-1, 0, 0}));
}

TEST_CASE("the two sides of a wall thinner than a cell stay apart", "[mapper][align]") {
  SurfaceMap map(small());
  map.add(wall(2.01F, -1.0F, 40000, 0.002, 1), {});
  map.add(wall(2.03F, 1.0F, 40000, 0.002, 2), {});
  const auto front = map.find({2.02F, 0.5F, 0.5F}, {-1, 0, 0});
  const auto back = map.find({2.02F, 0.5F, 0.5F}, {1, 0, 0});
  REQUIRE(front);
  REQUIRE(back);
  CHECK(std::abs(front->point_m[0] - 2.01F) < 0.001F);
  CHECK(std::abs(back->point_m[0] - 2.03F) < 0.001F);
}

TEST_CASE("the order of a frame's samples does not matter, to the last bit", "[mapper][align]") {
  SurfaceMap a(small());
  SurfaceMap b(small());
  std::mt19937 random(7);
  for (int frame = 0; frame < 200; ++frame) {  // enough for sums to be halved
    std::vector<DepthSample> samples = wall(2.0F, -1.0F, 2000, 0.02, static_cast<std::uint64_t>(frame));
    a.add(samples, {});
    std::shuffle(samples.begin(), samples.end(), random);
    b.add(samples, {});
  }
  CHECK(a.piece_count() == b.piece_count());
  for (float y = 0.0F; y < 1.0F; y += 0.01F) {
    const auto p = a.find({2.0F, y, 0.5F}, {-1, 0, 0});
    const auto q = b.find({2.0F, y, 0.5F}, {-1, 0, 0});
    REQUIRE(p.has_value() == q.has_value());
    if (!p) continue;
    CHECK(p->point_m == q->point_m);
    CHECK(p->normal == q->normal);
  }
}

TEST_CASE("what was seen lately counts more than what was seen long ago", "[mapper][align][long]") {
  SurfaceMap map(small());
  for (int frame = 0; frame < 50; ++frame)
    map.add(wall(2.012F, -1.0F, 20000, 0.0, static_cast<std::uint64_t>(frame)), {});
  for (int frame = 0; frame < 50; ++frame)
    map.add(wall(2.032F, -1.0F, 20000, 0.0, static_cast<std::uint64_t>(frame)), {});
  const auto piece = map.find({2.02F, 0.5F, 0.5F}, {-1, 0, 0});
  REQUIRE(piece);
  CHECK(std::abs(piece->point_m[0] - 2.032F) < 0.002F);
}

TEST_CASE("a full table takes no new pieces, counts what it refused and keeps what it has", "[mapper][align]") {
  SurfaceMap map({.rule = {.cell_m = 0.05F}, .slots = 64});
  for (int frame = 0; frame < 5; ++frame) map.add(wall(2.012F, -1.0F, 4000, 0.0, 1), {});
  CHECK(map.piece_count() == 63);  // all but one in the first frame, none later
  CHECK(map.refused() > 1000);
  std::size_t pieces = 0;
  map.for_each([&](const SurfacePiece& piece, float weight) {
    CHECK(std::abs(piece.point_m[0] - 2.012F) < 0.001F);
    CHECK(weight > 0.0F);
    ++pieces;
  });
  CHECK(pieces > 40);
}

TEST_CASE("places beyond any building, and what is no number, are refused", "[mapper][align]") {
  SurfaceMap map(small());
  for (const float far :
       {1e5F, -1e5F, 1e30F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    map.add(wall(far, -1.0F, 10, 0.0, 1), {});
    CHECK_FALSE(map.find({far, 0.5F, 0.5F}, {-1, 0, 0}));
  }
  CHECK(map.piece_count() == 0);
  CHECK(map.refused() == 50);
}

TEST_CASE(
    "Pieces move with the correction of the time of their birth, and the older of two that meet stays the older") {
  SurfaceMap map;
  const auto wall_at = [](float x_m) {
    std::vector<DepthSample> wall;
    for (int i = 0; i < 50; ++i) {
      wall.push_back(
          {{x_m, 0.02F * static_cast<float>(i % 4), 0.02F * static_cast<float>(i / 4 % 4)}, {-1, 0, 0}, 1.0F});
    }
    return wall;
  };
  map.add(wall_at(2.03F), {}, 100);
  map.add(wall_at(3.43F), {}, 200);
  REQUIRE(map.piece_count() == 2);
  map.move([](hal::TimeNs born_ns) {
    return born_ns == 100 ? hal::Pose{} : hal::from_xyz_rpy(-1.4, 0.0, 0.0, 0.0, 0.0, 0.0);
  });
  CHECK(map.piece_count() == 1);
  const auto piece = map.find({2.03F, 0.03F, 0.03F}, {-1, 0, 0}, 150);  // both are one, born at 100
  REQUIRE(piece);
  CHECK(piece->point_m[0] == Approx(2.03F).margin(0.002));
  CHECK_FALSE(map.find({3.43F, 0.03F, 0.03F}, {-1, 0, 0}));

  map.move([](hal::TimeNs) { return hal::from_xyz_rpy(0.0, 0.0, 0.0, 0.0, 0.0, 1.5707963); });
  const auto turned = map.find({-0.03F, 2.03F, 0.03F}, {0, -1, 0});
  REQUIRE(turned);
  CHECK(turned->point_m[1] == Approx(2.03F).margin(0.003));
  CHECK(turned->normal[1] == Approx(-1.0F).margin(0.01));
  map.clear();
  CHECK(map.piece_count() == 0);
  CHECK_FALSE(map.find({-0.03F, 2.03F, 0.03F}, {0, -1, 0}));
}

namespace {

/// One cell of surface, seen `times` times; sure of itself from a few on.
void show(SurfaceMap& map, int x, int y, int times) {
  const std::vector<DepthSample> sample(
      static_cast<std::size_t>(times),
      {{0.05F * (static_cast<float>(x) + 0.5F), 0.05F * (static_cast<float>(y) + 0.5F), 0.5F}, {-1, 0, 0}, 0.5F});
  map.add(sample, {});
}

bool knows(const SurfaceMap& map, int x, int y) {
  return map.find({0.05F * (static_cast<float>(x) + 0.5F), 0.05F * (static_cast<float>(y) + 0.5F), 0.5F}, {-1, 0, 0})
      .has_value();
}

/// Seen once, all in one frame, and hardly to be seen at all.
void show_poor(SurfaceMap& map, int count) {
  std::vector<DepthSample> poor;
  for (int i = 0; i < count; ++i) {
    poor.push_back({{0.05F * (static_cast<float>(i) + 0.5F), 1.0F, 0.5F}, {-1, 0, 0}, 0.01F});
  }
  map.add(poor, {});
}

}  // namespace

TEST_CASE("in a table that fills with good pieces those go that have not been seen for longest", "[mapper][align]") {
  SurfaceMap map({.rule = {.cell_m = 0.05F}, .slots = 1024});
  for (int i = 0; i < 500; ++i) show(map, i, 0, 4);
  CHECK(map.make_room() == 0);  // of 1024
  show_poor(map, 120);
  CHECK(map.make_room() > 80);  // what is poor was seen just now
  CHECK(map.piece_count() <= 410 + 120);
  CHECK_FALSE(knows(map, 0, 0));
  CHECK(knows(map, 499, 0));
  for (int i = 1; i < 500; ++i) REQUIRE(knows(map, i, 0) >= knows(map, i - 1, 0));
}

TEST_CASE("poor pieces that were not seen lately are forgotten first, and others are found as before",
          "[mapper][align]") {
  SurfaceMap map({.rule = {.cell_m = 0.05F}, .slots = 1024});
  show_poor(map, 450);
  for (int i = 0; i < 200; ++i) show(map, i, 0, 4);
  CHECK(map.make_room() == 450);
  CHECK(map.piece_count() == 200);
  for (int i = 0; i < 300; ++i) show(map, i, 8, 4);  // there is room again, and no key is lost
  for (int i = 0; i < 200; ++i) REQUIRE(knows(map, i, 0));
  for (int i = 0; i < 300; ++i) REQUIRE(knows(map, i, 8));
}

TEST_CASE("which pieces are forgotten does not depend on the order in which they came", "[mapper][align]") {
  SurfaceMap a(small());
  SurfaceMap b(small());
  std::mt19937 random(3);
  std::size_t forgotten = 0;
  for (int frame = 0; frame < 40; ++frame) {
    auto samples = wall(1.0F + 0.06F * static_cast<float>(frame), -1.0F, 1500, 0.01, static_cast<std::uint64_t>(frame));
    const std::size_t of_a = a.make_room();
    CHECK(b.make_room() == of_a);
    forgotten += of_a;
    a.add(samples, {});
    std::shuffle(samples.begin(), samples.end(), random);
    b.add(samples, {});
  }
  CHECK(forgotten > 1000);
  REQUIRE(a.piece_count() == b.piece_count());
  for (const SurfaceCell& cell : a.table()) {
    if (cell.key == 0) continue;
    const SurfaceCell* other = b.look_up(cell.key);
    REQUIRE(other != nullptr);
    CHECK(other->weight == cell.weight);
    CHECK(other->frame == cell.frame);
  }
}
