// SPDX-License-Identifier: Apache-2.0
// What a map must not get wrong, at full image size: free space behind closed walls after a drive with dropouts, and
// thin poles that the exact map has and the projective one loses.
//   scene_bench [--resolution METRES]... [--frames N]
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "mapper/mapper.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;

namespace {

mapper::MapperConfig config_for(mapper::IntegratorKind kind, float resolution_m) {
  mapper::MapperConfig config;
  config.integrator = kind;
  config.resolution_m = resolution_m;
  config.capacity = mapper::capacity_for_bytes(std::size_t{768} << 20);
  return config;
}

// The western room of `two_rooms` is x -4.05..-0.05, y -2..2, z 0..2.4, with walls of 10 cm around it.
void tunnelling(const test::Workload& work, float resolution_m) {
  constexpr std::array<double, 3> kLow_m{-4.15, -2.1, -0.1};
  constexpr std::array<double, 3> kHigh_m{0.05, 2.1, 2.5};
  for (const auto kind :
       {mapper::IntegratorKind::dda, mapper::IntegratorKind::bresenham, mapper::IntegratorKind::projective}) {
    mapper::Mapper mapper(config_for(kind, resolution_m), work.camera);
    for (const test::PosedImage& image : work.frames) (void)mapper.integrate(image.frame, image.T_world_camera);
    std::uint64_t free = 0;
    std::uint64_t behind = 0;
    mapper::BlockValues values;
    for (const mapper::BlockKey key : mapper.map().sorted_keys()) {
      mapper.map().read_block(key, values);
      for (mapper::MCode place = 0; place < mapper::kBlockVoxels; ++place) {
        if (mapper::state_of(values[place]) != mapper::State::free) continue;
        const auto c = mapper.map().grid().centre_m(mapper::decode((key << mapper::kBlockShift) | place));
        bool inside = true;
        for (std::size_t axis = 0; axis < 3; ++axis) inside &= c[axis] > kLow_m[axis] && c[axis] < kHigh_m[axis];
        ++free;
        behind += inside ? 0 : 1;
      }
    }
    fmt::print("tunnelling  {:10} r={:.3f}: {} of {} free voxels lie behind closed walls, {:.4f} %\n",
               mapper::to_string(kind), resolution_m, behind, free,
               100.0 * static_cast<double>(behind) / static_cast<double>(free));
    std::fflush(stdout);
  }
}

struct Pole {
  double x_m, y_m, radius_m, low_m, high_m;
};
// The free-standing poles of `furnished_room`.
constexpr std::array<Pole, 4> kPoles{{{-1.75, 1.75, 0.01, 0.1, 1.6},
                                      {1.75, 1.8, 0.0125, 0.1, 1.6},
                                      {1.75, -1.75, 0.015, 0.1, 1.6},
                                      {-3.1, -3.3, 0.01, 0.1, 1.1}}};

/// Layers of voxels in which the map has something occupied where the pole stands.
int layers_with_pole(const mapper::VoxelMap& map, const Pole& pole) {
  const mapper::Grid& grid = map.grid();
  const auto index = [&](double x) { return grid.to_index(static_cast<float>(x)); };
  const double reach_m = pole.radius_m + 0.03;  // range noise moves a pole by a few centimetres
  int layers = 0;
  for (std::int32_t z = index(pole.low_m); z <= index(pole.high_m); ++z) {
    bool found = false;
    for (std::int32_t y = index(pole.y_m - reach_m); y <= index(pole.y_m + reach_m); ++y) {
      for (std::int32_t x = index(pole.x_m - reach_m); x <= index(pole.x_m + reach_m); ++x) {
        found |= mapper::state_of(map.at(mapper::VoxelIndex{x, y, z})) == mapper::State::occupied;
      }
    }
    layers += found ? 1 : 0;
  }
  return layers;
}

void poles(const test::Workload& work, float resolution_m) {
  mapper::Mapper exact(config_for(mapper::IntegratorKind::dda, resolution_m), work.camera);
  mapper::Mapper projective(config_for(mapper::IntegratorKind::projective, resolution_m), work.camera);
  for (const test::PosedImage& image : work.frames) {
    (void)exact.integrate(image.frame, image.T_world_camera);
    (void)projective.integrate(image.frame, image.T_world_camera);
  }
  for (const Pole& pole : kPoles) {
    fmt::print("thin pole   r={:.3f}: {:.1f} cm thick, layers occupied in the exact map {}, in the projective one {}\n",
               resolution_m, 200.0 * pole.radius_m, layers_with_pole(exact.map(), pole),
               layers_with_pole(projective.map(), pole));
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  int frames = 120;
  std::vector<float> resolutions_m;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--frames") == 0) frames = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--resolution") == 0) resolutions_m.push_back(static_cast<float>(std::atof(argv[i + 1])));
  }
  if (resolutions_m.empty()) resolutions_m = {0.05F, 0.02F};
  const test::Workload closed = test::simulated_drive("two_rooms", frames, 30.0 / frames);
  for (const float r : resolutions_m) tunnelling(closed, r);
  const test::Workload room = test::simulated_drive("furnished_room", frames, 60.0 / frames);
  for (const float r : resolutions_m) poles(room, r);
  return 0;
}
