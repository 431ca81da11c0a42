// SPDX-License-Identifier: Apache-2.0
#include "mapper/merge.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "mapper/map_hash.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

std::unique_ptr<VoxelMap> merged(const std::vector<MergeSource>& sources, const MergeOptions& options = {}) {
  auto result = merge_maps(sources, options);
  REQUIRE(result.ok());
  return std::move(result).value();
}

std::unique_ptr<VoxelMap> one_voxel(const VoxelIndex& v, Rgbo code, float resolution_m = 0.05F) {
  auto map = std::make_unique<VoxelMap>(Grid{resolution_m}, MapCapacity{8, 8, 8});
  BlockValues values;
  values.fill(kUnknownRgbo);
  values[encode(v) & kPlaceMask] = code;
  REQUIRE(map->write_block(block_of(v), values));
  return map;
}

const VoxelIndex kHere{32770, 32771, 32772};

Rgbo merged_voxel(const std::vector<Rgbo>& codes) {
  std::vector<std::unique_ptr<VoxelMap>> maps;
  std::vector<MergeSource> sources;
  for (const Rgbo code : codes) {
    maps.push_back(one_voxel(kHere, code));
    sources.push_back({maps.back().get(), {}, maps.size()});
  }
  return merged(sources)->at(kHere);
}

}  // namespace

TEST_CASE("Levels add up around unknown and are clamped once, at the end") {
  CHECK(merged_voxel({20, 20}) == 24);
  CHECK(merged_voxel({20, 12}) == 16);
  CHECK(merged_voxel({32, 32}) == 32);
  CHECK(merged_voxel({0, 0}) == 0);
  CHECK(merged_voxel({32, 32, 0}) == 32);  // 16 + 16 - 16: clamping in between would give 16
  CHECK(merged_voxel({0, 0, 0, 32, 32}) == 0);
  CHECK(merged_voxel({16, 18}) == 18);  // who does not know has no say
}

TEST_CASE("The surest map gives the colour, ties the lowest layer, then the lowest colour") {
  const Rgbo red = make_rgbo(200, 0, 0, 20) | kHasColourBit;
  const Rgbo blue = make_rgbo(0, 0, 200, 24) | kHasColourBit;
  const Rgbo green = make_rgbo(0, 200, 0, 24) | kHasColourBit;
  CHECK(merged_voxel({red, blue}) >> 8 == 0x0000C8);
  CHECK(merged_voxel({green, red, blue}) >> 8 == 0x00C800);
  CHECK(merged_voxel({32, red}) >> 8 == 0xC80000);  // a map without colours does not take them away
  CHECK(merged_voxel({0, red}) == 4);               // and what ends up free has none
  const auto a = one_voxel(kHere, blue);
  const auto b = one_voxel(kHere, green);
  CHECK(merged({{a.get(), {}, 5}, {b.get(), {}, 5}})->at(kHere) >> 8 == 0x0000C8);
  CHECK(merged({{b.get(), {}, 5}, {a.get(), {}, 5}})->at(kHere) >> 8 == 0x0000C8);
  CHECK(merged({{a.get(), {}, 6}, {b.get(), {}, 5}})->at(kHere) >> 8 == 0x00C800);
}

TEST_CASE("Merging one map in place gives it back") {
  const auto map = tests::random_map(71, 300);
  CHECK(tests::same_map(*map, *merged({{map.get(), {}, 1}})));
}

TEST_CASE("The order of the maps does not matter, turned ones included", "[slow]") {
  std::vector<std::unique_ptr<VoxelMap>> maps;
  for (std::uint64_t i = 0; i < 4; ++i) maps.push_back(tests::random_map(72 + i, 60));
  std::vector<MergeSource> sources{{maps[0].get(), {}, 3},
                                   {maps[1].get(), hal::from_xyz_rpy(0.40, -0.8, 0, 0, 0, 0), 3},
                                   {maps[2].get(), hal::from_xyz_rpy(0.15, 0.05, -0.1, 0, 0, 0), 1},
                                   {maps[3].get(), hal::from_xyz_rpy(0.1, 0.2, 0.3, 0.1, -0.2, 0.7), 2}};
  std::vector<std::size_t> order{0, 1, 2, 3};
  std::string first;
  do {
    std::vector<MergeSource> permuted;
    for (const std::size_t i : order) permuted.push_back(sources[i]);
    const std::string hash = map_hash(*merged(permuted));
    if (first.empty()) first = hash;
    REQUIRE(hash == first);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_CASE("any number of threads merges to the same map", "[mapper][merge][threads]") {
  const auto a = tests::random_map(81, 90);
  const auto b = tests::random_map(82, 90);
  const std::vector<MergeSource> sources{{a.get(), {}, 1},
                                         {b.get(), hal::from_xyz_rpy(0.1, 0.2, 0.3, 0.1, -0.2, 0.7), 2}};
  MergeOptions options;
  const std::string one = map_hash(*merged(sources, options));
  options.threads = 3;
  CHECK(map_hash(*merged(sources, options)) == one);
}

TEST_CASE("Whole voxels of shift are exact, voxel by voxel") {
  const auto a = tests::random_map(76, 80);
  const auto b = tests::random_map(77, 80);
  const VoxelIndex shift = GENERATE(VoxelIndex{0, 0, 0}, VoxelIndex{8, -16, 24}, VoxelIndex{3, -5, 1});
  const double r = static_cast<double>(0.05F);
  const hal::Pose T_world_b{{shift.x * r, shift.y * r, shift.z * r}, {0, 0, 0, 1}};
  const auto both = merged({{a.get(), {}, 1}, {b.get(), T_world_b, 2}});
  std::uint64_t wrong = 0;
  for (int x = 32730; x < 32800; x += 1) {
    for (int y = 32730; y < 32800; y += 1) {
      for (int z = 32730; z < 32800; z += 3) {
        const int in_a = level_of(a->at(VoxelIndex{x, y, z}));
        const int in_b = level_of(b->at(VoxelIndex{x - shift.x, y - shift.y, z - shift.z}));
        const int expected = std::clamp(in_a + in_b - 16, 0, 32);
        wrong += level_of(both->at(VoxelIndex{x, y, z})) != expected ? 1 : 0;
      }
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("A turned map is looked up where each voxel's centre falls") {
  const auto a = tests::random_map(78, 60, 0.1F);
  const hal::Pose T_world_a = hal::from_xyz_rpy(0.33, -0.21, 0.07, 0.3, -0.2, 1.1);
  MergeOptions options;
  options.resolution_m = 0.05F;
  const auto turned = merged({{a.get(), T_world_a, 1}}, options);
  REQUIRE(turned->counts().known() > 1000);
  const hal::Pose T_a_world = hal::inverse(T_world_a);
  std::uint64_t wrong = 0;
  std::uint64_t known = 0;
  std::uint64_t closed = 0;
  for (int x = 32720; x < 32820; x += 2) {
    for (int y = 32720; y < 32820; y += 2) {
      for (int z = 32720; z < 32820; z += 2) {
        const auto p = turned->grid().centre_m(VoxelIndex{x, y, z});
        const auto q = hal::compose(T_a_world, {{p[0], p[1], p[2]}, {0, 0, 0, 1}}).translation_m;
        const auto k = [&](double m) { return 32767 + static_cast<int>(std::ceil(m / static_cast<double>(0.1F))); };
        const Rgbo expected = a->at(VoxelIndex{k(q[0]), k(q[1]), k(q[2])});
        const bool differs = turned->at(VoxelIndex{x, y, z}) != expected;
        // Between two centres something was in the way (wall_closing.hpp).
        const bool is_closed = differs && state_of(expected) != State::occupied &&
                               state_of(turned->at(VoxelIndex{x, y, z})) == State::occupied;
        wrong += differs && !is_closed ? 1 : 0;
        closed += is_closed ? 1 : 0;
        known += expected != kUnknownRgbo ? 1 : 0;
      }
    }
  }
  CHECK(known > 100);
  CHECK(wrong <= known / 10000);  // a centre on a voxel's face may round either way
  CHECK(closed <= known / 20);
}

TEST_CASE("Merging says what is wrong with its arguments") {
  CHECK(merge_maps({}).error().reason == hal::Reason::bad_usage);
  const auto map = tests::random_map(79, 60);
  MergeSource bad{map.get(), {}, 1};
  bad.T_world_map.rotation_xyzw = {0, 0, 0, 0};
  CHECK(merge_maps(std::vector{bad}).error().reason == hal::Reason::bad_usage);
  MergeOptions options;
  options.resolution_m = -1.0F;
  CHECK(merge_maps(std::vector<MergeSource>{{map.get(), {}, 1}}, options).error().reason == hal::Reason::bad_usage);
  options.resolution_m.reset();
  options.capacity = MapCapacity{3, 3, 3};
  CHECK(merge_maps(std::vector<MergeSource>{{map.get(), {}, 1}}, options).error().reason == hal::Reason::no_capacity);
}
