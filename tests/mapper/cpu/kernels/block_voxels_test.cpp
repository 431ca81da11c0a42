// SPDX-License-Identifier: Apache-2.0
// Each block kernel, in every variant, against the same formula for one voxel at a time.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "mapper/voxel_map.hpp"
#include "tests/support/kernel_variants.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;
using tests::Random;

namespace {

float between(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }

struct Brick {
  ProjectionTables tables;
  std::vector<std::uint16_t> image;
  ProjectBrick numbers{};
};

/// A brick somewhere in front of, around or behind the camera, against a noisy image.
std::unique_ptr<Brick> random_brick(Random& random) {
  auto brick = std::make_unique<Brick>();
  constexpr int kStride = 96;
  constexpr int kRows = 80;
  brick->image.resize(kStride * kRows);
  for (std::uint16_t& raw : brick->image)
    raw = static_cast<std::uint16_t>(random.below(3) == 0 ? 3500 : random.below(4000));
  for (std::size_t i = 0; i < 512; ++i) {
    brick->tables.x_px_m[i] = between(random, -20, 20);
    brick->tables.y_px_m[i] = between(random, -20, 20);
    brick->tables.z_units[i] = between(random, -300, 300);
  }
  ProjectBrick& b = brick->numbers;
  b.tables = &brick->tables;
  b.first_place = 64 * static_cast<int>(random.below(8));
  b.x_px_m = between(random, -200, 200);
  b.y_px_m = between(random, -150, 150);
  b.z_units = random.below(4) == 0 ? between(random, -400, 400) : between(random, 500, 3700);
  b.metres_per_unit = 0.001F;
  b.min_z_units = 25.0F;
  b.bias_units = between(random, -30, 60);
  b.scale = std::array<float, 3>{1.0F, 0.5F, 0.25F}[random.below(3)];
  b.shift_x = between(random, 30, 60);
  b.shift_y = between(random, 20, 50);
  b.first_x = 5.0F;
  b.first_y = 6.0F;
  b.last_x = static_cast<float>(kStride - 9);
  b.last_y = static_cast<float>(kRows - 9);
  b.at_border = random.below(2) == 0;
  b.left_px = -60;
  b.right_px = 50;
  b.top_px = -40;
  b.bottom_px = 45;
  for (float& reach : b.reach_px_m) reach = between(random, 0, 10);
  b.far_units = 3500;
  b.far_bias_units = between(random, -60, 60);
  b.stride = kStride;
  b.image = brick->image.data();
  return brick;
}

bool slow_is_free(const ProjectBrick& b, std::size_t place) {
  const float x_px_m = b.x_px_m + b.tables->x_px_m[place];
  const float y_px_m = b.y_px_m + b.tables->y_px_m[place];
  const float z_units = b.z_units + b.tables->z_units[place];
  if (z_units < b.min_z_units) return false;
  const float z_m = z_units * b.metres_per_unit;
  if (b.at_border) {
    if (x_px_m + b.reach_px_m[0] < b.left_px * z_m || x_px_m - b.reach_px_m[1] > b.right_px * z_m) return false;
    if (y_px_m + b.reach_px_m[2] < b.top_px * z_m || y_px_m - b.reach_px_m[3] > b.bottom_px * z_m) return false;
  }
  const float inverse = b.scale / z_m;
  const int x = static_cast<int>(std::clamp(x_px_m * inverse + b.shift_x, b.first_x, b.last_x));
  const int y = static_cast<int>(std::clamp(y_px_m * inverse + b.shift_y, b.first_y, b.last_y));
  const auto seen_units = static_cast<float>(b.image[y * b.stride + x]);
  if (seen_units >= z_units + b.bias_units) return true;
  return z_units + b.far_bias_units <= b.far_units && seen_units >= b.far_units;
}

struct Evidence {
  LevelPlane levels;
  std::array<std::uint8_t, 512> hits;
  std::array<std::uint8_t, 512> free;
};

Evidence random_evidence(Random& random) {
  Evidence e;
  const std::uint32_t kind = random.below(4);
  const auto base = static_cast<std::uint8_t>(random.below(33));
  for (std::size_t i = 0; i < 512; ++i) {
    e.levels[i] = kind == 0 ? base : static_cast<std::uint8_t>(random.below(33));
    if (kind != 0 && e.levels[i] > kUnknownLevel && random.below(2) == 0) e.levels[i] |= kHasColourBit;
    e.hits[i] = kind == 1 && random.below(4) == 0
                    ? static_cast<std::uint8_t>(random.below(2) == 0 ? kHitFlag : kHitFlag | kColourFlag)
                    : 0;
    e.free[i] = kind == 0 ? kStrongFree : std::array<std::uint8_t, 3>{0, kWeakFree, kStrongFree}[random.below(3)];
  }
  return e;
}

}  // namespace

TEST_CASE("project_brick frees the voxels that the formula frees, and no other place is touched") {
  Random random(1);
  int freed = 0;
  int kept = 0;
  for (int round = 0; round < 400; ++round) {
    const auto brick = random_brick(random);
    const auto first = static_cast<std::size_t>(brick->numbers.first_place);
    for (const Kernels* kernels : test::kernel_variants()) {
      alignas(64) std::array<std::uint8_t, 512> free;
      free.fill(0xCD);
      const bool any = kernels->project_brick(brick->numbers, free.data());
      bool expected_any = false;
      int wrong = 0;
      for (std::size_t place = 0; place < 512; ++place) {
        const bool in_brick = place >= first && place < first + 64;
        const bool is_free = in_brick && slow_is_free(brick->numbers, place);
        wrong += free[place] == (in_brick ? (is_free ? kWeakFree : 0) : 0xCD) ? 0 : 1;
        expected_any |= is_free;
        if (in_brick) (is_free ? freed : kept) += 1;
      }
      INFO(kernels->name << " round " << round);
      REQUIRE(wrong == 0);
      REQUIRE(any == expected_any);
    }
  }
  CHECK(freed > 1000);
  CHECK(kept > 1000);
}

TEST_CASE("bound_boxes covers the projections of all corners, and every variant says the same") {
  Random random(4);
  int hidden = 0;
  int inside = 0;
  int clear = 0;
  for (int round = 0; round < 60; ++round) {
    BoxView view{};
    view.half_x_m = between(random, 0.05, 0.4);
    view.half_y_m = between(random, 0.05, 0.4);
    view.half_z_m = between(random, 0.05, 0.4);
    view.fx_px = 131;
    view.fy_px = 130;
    view.cx_px = 79.5F;
    view.cy_px = 59.25F;
    view.last_u_px = 159;
    view.last_v_px = 119;
    view.near_plane_m = 0.1F;
    view.far_m = 3.5F;
    view.window_px_m = between(random, 0, 8);
    // Planes through the camera and the image's borders, against cubes along the camera's axes.
    view.left_px = -view.cx_px;
    view.right_px = view.last_u_px - view.cx_px;
    view.top_px = -view.cy_px;
    view.bottom_px = view.last_v_px - view.cy_px;
    const auto reach_px_m = [&](float f, float half_m, float border) {
      return f * half_m + std::abs(border) * view.half_z_m + 0.005F;
    };
    view.outer_px_m[0] = view.inner_px_m[0] = reach_px_m(view.fx_px, view.half_x_m, view.left_px);
    view.outer_px_m[1] = view.inner_px_m[1] = reach_px_m(view.fx_px, view.half_x_m, view.right_px);
    view.outer_px_m[2] = view.inner_px_m[2] = reach_px_m(view.fy_px, view.half_y_m, view.top_px);
    view.outer_px_m[3] = view.inner_px_m[3] = reach_px_m(view.fy_px, view.half_y_m, view.bottom_px);
    const int count = round % 3 == 0 ? 1 : round % 3 == 1 ? 8 : 64;
    BoxBounds at{};
    for (std::size_t i = 0; i < 64; ++i) {
      at.z_m[i] = between(random, -0.5, 4.2);
      at.x_m[i] = between(random, -0.9, 0.9) * std::max(at.z_m[i], 0.3F);
      at.y_m[i] = between(random, -0.7, 0.7) * std::max(at.z_m[i], 0.3F);
    }
    BoxBounds first = at;
    kernels_by_name("baseline").bound_boxes(view, count, first);
    for (const Kernels* kernels : test::kernel_variants()) {
      BoxBounds found = at;
      kernels->bound_boxes(view, count, found);
      const auto end = static_cast<std::size_t>(count);
      for (std::size_t i = 0; i < end; ++i) {
        REQUIRE((found.hidden[i] == first.hidden[i] && found.inside[i] == first.inside[i]));
        REQUIRE(found.clear[i] == first.clear[i]);
        REQUIRE((found.u0[i] == first.u0[i] && found.u1[i] == first.u1[i]));
        REQUIRE((found.v0[i] == first.v0[i] && found.v1[i] == first.v1[i]));
      }
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      REQUIRE((first.u0[i] >= 0 && first.u0[i] <= first.u1[i] && first.u1[i] <= 159));
      REQUIRE((first.v0[i] >= 0 && first.v0[i] <= first.v1[i] && first.v1[i] <= 119));
      const bool in_front = at.z_m[i] - view.half_z_m > view.near_plane_m;
      hidden += first.hidden[i];
      inside += first.inside[i];
      if (!in_front) {
        REQUIRE(first.inside[i] == 0);
        REQUIRE((first.u0[i] == 0 && first.u1[i] == 159 && first.v0[i] == 0 && first.v1[i] == 119));
        if (at.z_m[i] + view.half_z_m <= 0.0F) REQUIRE(first.hidden[i] == 1);
        continue;
      }
      bool corner_in_image = false;
      bool all_in_image = true;
      for (int corner = 0; corner < 8; ++corner) {
        const float x = at.x_m[i] + (corner % 2 == 0 ? -view.half_x_m : view.half_x_m);
        const float y = at.y_m[i] + (corner / 2 % 2 == 0 ? -view.half_y_m : view.half_y_m);
        const float z = at.z_m[i] + (corner / 4 == 0 ? -view.half_z_m : view.half_z_m);
        const float u = view.fx_px * x / z + view.cx_px;
        const float v = view.fy_px * y / z + view.cy_px;
        const bool in_image = u >= 0 && u <= 159 && v >= 0 && v <= 119;
        corner_in_image |= in_image;
        all_in_image &= in_image;
        if (first.inside[i] != 0) REQUIRE((u > -0.01F && u < 159.01F && v > -0.01F && v < 119.01F));
        if (!in_image) continue;
        const float window_px = 0.5F * view.window_px_m / z;
        REQUIRE(static_cast<float>(first.u0[i]) <= std::max(0.0F, u - window_px));
        REQUIRE(static_cast<float>(first.u1[i]) >= std::floor(std::min(159.0F, u + window_px)));
        REQUIRE(static_cast<float>(first.v0[i]) <= std::max(0.0F, v - window_px));
        REQUIRE(static_cast<float>(first.v1[i]) >= std::floor(std::min(119.0F, v + window_px)));
      }
      clear += first.clear[i];
      if (first.clear[i] != 0) REQUIRE(all_in_image);
      if (corner_in_image && at.z_m[i] - view.half_z_m <= view.far_m) REQUIRE(first.hidden[i] == 0);
      if (at.z_m[i] - view.half_z_m > view.far_m) REQUIRE(first.hidden[i] == 1);
    }
  }
  CHECK(hidden > 50);
  CHECK(inside > 50);
  CHECK(clear > 50);
}

TEST_CASE("apply_block moves each voxel by the update rules, with all steps") {
  Random random(2);
  for (int round = 0; round < 600; ++round) {
    const Evidence before = random_evidence(random);
    const UpdateSteps steps{static_cast<std::uint8_t>(1 + random.below(16)),
                            static_cast<std::uint8_t>(1 + random.below(16))};
    const bool with_hits = random.below(4) != 0;
    const bool with_free = random.below(4) != 0;
    LevelPlane expected;
    std::uint8_t lost = 0;
    for (std::size_t i = 0; i < 512; ++i) {
      test::PlainVoxel voxel;
      voxel.level = before.levels[i] & kLevelMask;
      voxel.has_colour = (before.levels[i] & kHasColourBit) != 0;
      const test::Seen seen = !with_free || before.free[i] == 0 ? test::Seen::no
                              : before.free[i] == kStrongFree   ? test::Seen::strong
                                                                : test::Seen::weak;
      test::plain_update(voxel, with_hits && before.hits[i] != 0, seen, nullptr, steps);
      expected[i] = static_cast<std::uint8_t>(voxel.level | (voxel.has_colour ? kHasColourBit : 0));
      if ((before.levels[i] & kHasColourBit) != 0 && !voxel.has_colour)
        lost = static_cast<std::uint8_t>(lost | (1U << (i / 64)));
    }
    const bool all_equal =
        std::all_of(expected.begin(), expected.end(), [&](std::uint8_t level) { return level == expected[0]; });
    for (const Kernels* kernels : test::kernel_variants()) {
      alignas(64) LevelPlane levels = before.levels;
      const ApplyResult result = kernels->apply_block(
          {levels.data(), with_hits ? before.hits.data() : nullptr, with_free ? before.free.data() : nullptr, steps});
      INFO(kernels->name << " round " << round);
      REQUIRE(levels == expected);
      REQUIRE(result.changed == (expected != before.levels));
      REQUIRE(result.all_equal == all_equal);
      REQUIRE(result.lost_colour == lost);
    }
  }
}

TEST_CASE("any_contested finds a single occupied voxel that only blind pixels see through") {
  Random random(3);
  for (int round = 0; round < 300; ++round) {
    Evidence e = random_evidence(random);
    if (round % 2 == 0) {  // nothing contested but perhaps one
      for (std::size_t i = 0; i < 512; ++i) {
        if ((e.levels[i] & kLevelMask) > kUnknownLevel && e.hits[i] == 0 && e.free[i] == kWeakFree)
          e.free[i] = kStrongFree;
      }
      if (round % 4 == 0) {
        const std::size_t place = random.below(512);
        e.levels[place] = 17;
        e.hits[place] = 0;
        e.free[place] = kWeakFree;
      }
    }
    bool expected = false;
    for (std::size_t i = 0; i < 512; ++i) {
      expected |= (e.levels[i] & kLevelMask) > kUnknownLevel && e.hits[i] == 0 && e.free[i] == kWeakFree;
    }
    for (const Kernels* kernels : test::kernel_variants()) {
      REQUIRE(kernels->any_contested(e.levels.data(), e.hits.data(), e.free.data()) == expected);
    }
  }
}
