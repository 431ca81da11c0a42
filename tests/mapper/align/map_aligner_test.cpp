// SPDX-License-Identifier: Apache-2.0
// Two robots' maps: joined where they show the same place, refused where they do not.
#include "mapper/align/map_aligner.hpp"

#include <catch2/catch.hpp>
#include <numbers>
#include <set>

#include "mapper/align/pose_step.hpp"
#include "tests/support/look_around.hpp"

using namespace g3d;
using namespace g3d::mapper::align;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Two looks around in one world, each map with its origin where the robot stood.
struct Pair {
  Pair(const std::string& world_a, std::uint64_t seed_a, const std::string& world_b, std::uint64_t seed_b)
      : a(make(world_a, seed_a, T_world_a)),
        b(make(world_b, seed_b, T_world_b)),
        surfaces_a(a->map()),
        surfaces_b(b->map()) {}
  static std::unique_ptr<mapper::Mapper> make(const std::string& world, std::uint64_t seed, hal::Pose& T_world_own) {
    const test::Workload work = test::look_around(world, seed);
    REQUIRE_FALSE(work.frames.empty());
    const auto& at = work.frames.front().T_world_camera.translation_m;
    T_world_own = {{at[0], at[1], 0.0}, {0, 0, 0, 1}};
    return test::map_in_own_frame(work, 0, work.frames.size(), 0.05F, hal::inverse(T_world_own));
  }
  [[nodiscard]] hal::Pose truth() const { return hal::compose(hal::inverse(T_world_a), T_world_b); }

  hal::Pose T_world_a, T_world_b;
  std::unique_ptr<mapper::Mapper> a, b;
  MapSurfaces surfaces_a, surfaces_b;
};

}  // namespace

TEST_CASE("a rough guess is put right to less than a voxel", "[mapper][align][slow]") {
  const Pair pair("furnished_room", 1, "furnished_room", 2);
  for (const auto& [shift_m, turn_deg] : {std::pair{0.0, 0.0}, {0.3, 10.0}, {1.0, -30.0}}) {
    const hal::Pose guess =
        hal::compose(pair.truth(), hal::from_xyz_rpy(0.6 * shift_m, -0.8 * shift_m, 0, 0, 0, turn_deg * kDegree));
    const MapAlignment found = align_maps(pair.surfaces_a, pair.surfaces_b, guess);
    INFO("off by " << shift_m << " m, " << turn_deg << " degrees: " << to_string(found.outcome) << ", overlap "
                   << found.overlap << ", runner-up " << found.runner_up);
    CHECK(found.outcome == MapAlignOutcome::aligned);
    const Vector6 error = difference(pair.truth(), found.T_a_b);
    CHECK(shift_of(error) < 0.04);  // less than a voxel
    CHECK(turn_of(error) < 0.3 * kDegree);
    CHECK(found.overlap > 0.9);
    CHECK(found.residual_m < 0.02);
  }
}

TEST_CASE("a place is found without any guess when that is asked for", "[mapper][align][slow]") {
  const Pair pair("furnished_room", 1, "furnished_room", 2);
  const hal::Pose guess = hal::from_xyz_rpy(2.0, 3.0, 0, 0, 0, 2.5);
  CHECK(align_maps(pair.surfaces_a, pair.surfaces_b, guess).outcome != MapAlignOutcome::aligned);
  const MapAlignment found = align_maps(pair.surfaces_a, pair.surfaces_b, guess, {.anywhere = true});
  CHECK(found.outcome == MapAlignOutcome::aligned);
  CHECK(shift_of(difference(pair.truth(), found.T_a_b)) < 0.04);
}

TEST_CASE("maps of different buildings are not joined", "[mapper][align][slow]") {
  const Pair pair("house", 1, "lab", 2);
  const MapAlignment found = align_maps(pair.surfaces_a, pair.surfaces_b, {});
  INFO(to_string(found.outcome) << ", overlap " << found.overlap);
  CHECK(found.outcome != MapAlignOutcome::aligned);
}

TEST_CASE("what could slide along itself is refused", "[mapper][align][slow]") {
  // In the middle of a straight corridor nothing says how far along it is.
  mapper::VoxelMap walls(mapper::Grid{0.05F}, {4096, 4096, 64});
  mapper::BlockValues values;
  for (int y = -80; y < 80; ++y) {
    for (int z = 0; z < 40; ++z) {
      for (const int x : {-20, 20}) {
        for (int step = -4; step <= 0; ++step) {
          const mapper::VoxelIndex v{32768 + (x < 0 ? x - step : x + step), 32768 + y, 32768 + z};
          walls.read_stored_block(mapper::block_of(v), values);
          values[mapper::encode(v) & 511U] = step == 0 ? 30 : 4;
          REQUIRE(walls.write_block(mapper::block_of(v), values));
        }
      }
    }
  }
  const MapSurfaces corridor(walls);
  CHECK(align_maps(corridor, corridor, {}).outcome == MapAlignOutcome::unfixed);
}

TEST_CASE("a map without surfaces aligns to nothing", "[mapper][align]") {
  mapper::VoxelMap empty(mapper::Grid{0.05F}, {64, 64, 64});
  const MapSurfaces none(empty);
  CHECK(align_maps(none, none, {}).outcome == MapAlignOutcome::too_little);
}

TEST_CASE("every outcome has a name of its own", "[mapper][align]") {
  std::set<std::string> names;
  for (int i = 0; i < 6; ++i) names.insert(to_string(static_cast<MapAlignOutcome>(i)));
  CHECK(names.size() == 6);
}
