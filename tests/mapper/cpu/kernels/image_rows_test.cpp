// SPDX-License-Identifier: Apache-2.0
// Each row kernel, in every variant, against one plain line of arithmetic per pixel.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/grid.hpp"
#include "mapper/morton.hpp"
#include "tests/support/kernel_variants.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;
using tests::Random;

namespace {

using Row = std::vector<std::uint16_t>;

constexpr std::uint16_t kNear = 800;
constexpr std::uint16_t kFar = 3500;
constexpr std::uint16_t kUntouched = 0xABCD;

/// Readings of all kinds, near each other often enough that not everything is an edge.
Row random_row(Random& random, int width) {
  Row row(static_cast<std::size_t>(width));
  std::uint32_t level = 2000;
  for (std::uint16_t& raw : row) {
    if (random.below(10) == 0) level = random.below(65536);
    raw = static_cast<std::uint16_t>(std::min(level + random.below(60), 65535U));
    if (random.below(8) == 0) raw = 0;
    if (random.below(20) == 0) raw = std::array<std::uint16_t, 6>{1, 799, 800, 3500, 3501, 65535}[random.below(6)];
  }
  return row;
}

/// Readings that bound a run, or none.
Row random_bounds(Random& random, int width) {
  Row row = random_row(random, width);
  for (std::uint16_t& raw : row) raw = raw == 0 || random.below(3) == 0 ? kUnbounded : raw;
  return row;
}

std::vector<int> lengths() { return {1, 2, 3, 7, 8, 15, 16, 17, 31, 32, 33, 63, 64, 65, 100, 159, 160, 333}; }

bool on_one_surface(int a, int b) { return std::abs(a - b) <= std::min(a, b) / 32 + std::min(a, b) / 128; }

}  // namespace

TEST_CASE("classify_row says what each reading is, and where a depth edge forbids colour") {
  Random random(1);
  for (const int width : lengths()) {
    for (int round = 0; round < 6; ++round) {
      const Row above = random_row(random, width);
      const Row row = round == 0 ? above : random_row(random, width);
      const Row below = round == 1 ? row : random_row(random, width);
      for (const Kernels* kernels : test::kernel_variants()) {
        INFO(kernels->name << " width " << width);
        const auto count = static_cast<std::size_t>(width);
        Row ends(count + 1, kUntouched);
        std::vector<std::uint8_t> colour(count + 1, 0xCD);
        std::vector<std::uint8_t> blind(count + 1, 0xCD);
        const RowCounts counts = kernels->classify_row(
            {row.data(), above.data(), below.data(), width, kNear, kFar, ends.data(), colour.data(), blind.data()});
        RowCounts expected;
        for (std::size_t u = 0; u < count; ++u) {
          const int d = row[u];
          expected.valid += d >= kNear && d <= kFar;
          expected.too_near += d > 0 && d < kNear;
          expected.far += d > kFar;
          expected.invalid += d == 0;
          REQUIRE(ends[u] == (d < kNear ? 0 : std::min<int>(d, kFar)));
          REQUIRE(blind[u] == (d == 0 ? 1 : 0));
          const bool smooth = on_one_surface(d, above[u]) && on_one_surface(d, below[u]) &&
                              (u == 0 || on_one_surface(d, row[u - 1])) &&
                              (u + 1 == count || on_one_surface(d, row[u + 1]));
          REQUIRE(colour[u] == (smooth ? kColourFlag : 0));
        }
        REQUIRE(counts.valid == expected.valid);
        REQUIRE(counts.too_near == expected.too_near);
        REQUIRE(counts.far == expected.far);
        REQUIRE(counts.invalid == expected.invalid);
        REQUIRE(ends[count] == kUntouched);
        REQUIRE(colour[count] == 0xCD);
        REQUIRE(blind[count] == 0xCD);
      }
    }
  }
}

TEST_CASE("carry_down bounds each blind pixel by the last reading above it") {
  Random random(2);
  for (const int width : lengths()) {
    const Row depth = random_row(random, width);
    const Row above = random_bounds(random, width);
    const Row beside = random_bounds(random, width);
    for (const Kernels* kernels : test::kernel_variants()) {
      Row last = above;
      Row ends = beside;
      kernels->carry_down(depth.data(), width, last.data(), ends.data());
      for (std::size_t i = 0; i < depth.size(); ++i) {
        REQUIRE(ends[i] == (depth[i] != 0 ? beside[i] : std::min(beside[i], above[i])));
        REQUIRE(last[i] == (depth[i] != 0 ? depth[i] : above[i]));
      }
    }
  }
}

TEST_CASE("bound_up takes the nearest of all bounds, and nothing if there is none or it is too near") {
  Random random(3);
  for (const int width : lengths()) {
    for (int round = 0; round < 6; ++round) {
      const Row depth = random_row(random, width);
      const Row so_far = random_bounds(random, width);
      const Row below = random_bounds(random, width);
      Row mask = random_row(random, width);
      for (std::uint16_t& raw : mask) raw = std::min(raw, kFar);
      for (const Kernels* kernels : test::kernel_variants()) {
        Row last = below;
        Row ends = so_far;
        kernels->bound_up({depth.data(), mask.data(), width, kNear, last.data(), ends.data()});
        for (std::size_t i = 0; i < depth.size(); ++i) {
          const std::uint16_t nearest = std::min(so_far[i], below[i]);
          const bool carves = nearest != kUnbounded && nearest >= kNear;
          const std::uint16_t weak = carves ? std::min(nearest, mask[i]) : std::uint16_t{0};
          REQUIRE(ends[i] == (depth[i] != 0 ? so_far[i] : weak));
          REQUIRE(last[i] == (depth[i] != 0 ? depth[i] : below[i]));
        }
      }
    }
  }
}

TEST_CASE("unproject_row finds the voxel of each reading that is not too far, and where the next run starts") {
  Random random(4);
  for (const int width : {4, 8, 36, 100, 332}) {
    const hal::CameraModel camera = test::small_camera(width);
    for (const float resolution_m : {0.01F, 0.05F, 0.25F}) {
      const SensorGeometry sensor(camera, resolution_m, 0.8F, 3.5F);
      for (std::uint64_t seed = 0; seed < 8; ++seed) {
        const hal::RigidTransform T = hal::to_transform(test::random_pose(seed));
        const auto frame = frame_geometry(sensor, T);
        REQUIRE(frame);
        const Row depth = random_row(random, width);
        const int v = static_cast<int>(random.below(static_cast<std::uint32_t>(camera.height_px)));
        const auto& R = T.rotation;
        std::vector<std::uint8_t> flags(depth.size());
        for (std::uint8_t& flag : flags) flag = random.below(4) == 0 ? std::uint8_t{0} : kColourFlag;
        for (const Kernels* kernels : test::kernel_variants()) {
          INFO(kernels->name << " width " << width << " seed " << seed);
          std::vector<std::uint32_t> ids(depth.size());
          Row places(depth.size());
          std::vector<std::uint8_t> starts(depth.size());
          UnprojectRow row{};
          row.depth = depth.data();
          row.column_slope = sensor.column_slope.data();
          row.width = width;
          row.near_raw = kNear;
          row.far_raw = kFar;
          row.metres_per_unit = sensor.metres_per_unit;
          row.resolution_m = resolution_m;
          for (std::size_t a = 0; a < 3; ++a) {
            row.column[a] = R[3 * a];
            row.row_part[a] = R[3 * a + 1] * sensor.row_slope[static_cast<std::size_t>(v)] + R[3 * a + 2];
            row.translation[a] = T.translation_m[a];
          }
          row.origin[0] = frame->origin.x;
          row.origin[1] = frame->origin.y;
          row.origin[2] = frame->origin.z;
          row.nx_blocks = frame->nx_blocks;
          row.nxy_blocks = frame->nx_blocks * frame->ny_blocks;
          row.block_id = ids.data();
          row.place = places.data();
          row.colour_flag = flags.data();
          std::vector<std::uint32_t> codes(depth.size());
          row.code = codes.data();
          row.starts = starts.data();
          kernels->unproject_row(row);
          const Grid grid{resolution_m};
          for (std::size_t u = 0; u < depth.size(); ++u) {
            const bool counts = depth[u] > 0 && depth[u] <= kFar;
            REQUIRE((ids[u] == kNoBlock) != counts);
            if (counts) {
              const float z = static_cast<float>(depth[u]) * sensor.metres_per_unit;
              std::array<float, 3> p;
              for (std::size_t a = 0; a < 3; ++a) {
                p[a] = (row.row_part[a] + sensor.column_slope[u] * row.column[a]) * z + row.translation[a];
              }
              const MCode code = encode(grid.to_index(p[0], p[1], p[2]));
              REQUIRE(frame->block_key(ids[u]) == code >> kBlockShift);
              REQUIRE(places[u] == (code & kPlaceMask));
            }
            const auto kind = [&](std::size_t i) { return depth[i] < kNear ? 2U : flags[i] != 0 ? 1U : 0U; };
            const bool differs = u == 0 || ids[u] != ids[u - 1] || places[u] != places[u - 1] || kind(u) != kind(u - 1);
            const bool starts_here = counts && differs;
            REQUIRE(starts[u] == (starts_here ? 1 : 0));
            REQUIRE(codes[u] == (ids[u] << 11 | static_cast<std::uint32_t>(places[u]) << 2 | kind(u)));
          }
        }
      }
    }
  }
}

TEST_CASE("drop_repeats drops what one of the three pixels above has said") {
  Random random(6);
  for (const int width : lengths()) {
    const auto n = static_cast<std::size_t>(width);
    std::vector<std::uint32_t> own(n);
    std::vector<std::uint32_t> above(n);
    std::vector<std::uint8_t> before(n);
    for (std::size_t u = 0; u < n; ++u) {
      own[u] = random.below(6);
      above[u] = random.below(6);
      before[u] = static_cast<std::uint8_t>(random.below(2));
    }
    for (const Kernels* kernels : test::kernel_variants()) {
      INFO(kernels->name << " width " << width);
      std::vector<std::uint8_t> starts = before;
      kernels->drop_repeats(own.data(), above.data(), width, starts.data());
      for (std::size_t u = 0; u < n; ++u) {
        const bool at_border = u == 0 || u + 1 >= n;
        const bool repeats = !at_border && (own[u] == above[u - 1] || own[u] == above[u] || own[u] == above[u + 1]);
        REQUIRE(starts[u] == (repeats ? 0 : before[u]));
      }
    }
  }
}

TEST_CASE("max_filter_row is the maximum of two pairs") {
  Random random(5);
  for (const int width : lengths()) {
    for (const int shift : {1, 2, 3, 6}) {
      const Row a = random_row(random, width + shift);
      const Row b = random_row(random, width + shift);
      for (const Kernels* kernels : test::kernel_variants()) {
        Row out(static_cast<std::size_t>(width) + 1, kUntouched);
        kernels->max_filter_row(a.data(), b.data(), shift, width, out.data());
        for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
          const std::size_t y = x + static_cast<std::size_t>(shift);
          REQUIRE(out[x] == std::max({a[x], a[y], b[x], b[y]}));
        }
        REQUIRE(out.back() == kUntouched);
      }
    }
  }
}

TEST_CASE("halving rows keeps the largest, or the smallest, of four") {
  Random random(6);
  for (const int width : lengths()) {
    const Row a = random_row(random, 2 * width);
    const Row b = random_row(random, 2 * width);
    for (const Kernels* kernels : test::kernel_variants()) {
      Row most(static_cast<std::size_t>(width) + 1, kUntouched);
      Row least = most;
      kernels->halve_max_row(a.data(), b.data(), width, most.data());
      kernels->halve_min_row(a.data(), b.data(), width, least.data());
      for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
        REQUIRE(most[x] == std::max({a[2 * x], a[2 * x + 1], b[2 * x], b[2 * x + 1]}));
        REQUIRE(least[x] == std::min({a[2 * x], a[2 * x + 1], b[2 * x], b[2 * x + 1]}));
      }
      REQUIRE(most.back() == kUntouched);
      REQUIRE(least.back() == kUntouched);
    }
  }
}
