// SPDX-License-Identifier: Apache-2.0
#include "tests/support/look_around.hpp"

#include <algorithm>
#include <numbers>

#include "hal/frame_pool.hpp"
#include "hal/sim/camera_path.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/reach.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/sim_renderer.hpp"

namespace g3d::test {

Workload look_around(const std::string& world_name, std::uint64_t seed) {
  Workload work;
  work.name = world_name;
  work.camera = hal::scaled_kinect(320, 240);
  auto world = hal::load_world(world_name);
  if (!world) return work;
  const auto starts = hal::choose_starts(world.value(), 1, seed);
  if (!starts) return work;
  const hal::PlanarPose at = starts.value()[0];
  hal::SimRenderer renderer(std::move(world).value(), {.camera = work.camera, .seed = seed, .threads = 2});
  constexpr int kFrames = 18;
  for (int i = 0; i < kFrames; ++i) {
    const double yaw_deg = at.heading_rad * 180.0 / std::numbers::pi + 20.0 * i;
    PosedImage image{hal::make_frame(work.camera), hal::camera_pose({at.x_m, at.y_m, 0.5}, yaw_deg, -5.0)};
    renderer.render(image.T_world_camera, i * 100'000'000LL, static_cast<std::uint64_t>(i), image.frame);
    work.frames.push_back(std::move(image));
  }
  return work;
}

std::unique_ptr<mapper::Mapper> map_in_own_frame(const Workload& work, std::size_t first, std::size_t count,
                                                 float resolution_m, const hal::Pose& T_map_world) {
  mapper::MapperConfig config;
  config.resolution_m = resolution_m;
  config.with_colour = false;
  config.capacity = mapper::capacity_for_bytes(std::size_t{256} << 20);
  config.threads = 2;
  auto made = std::make_unique<mapper::Mapper>(config, work.camera);
  for (std::size_t i = first; i < std::min(first + count, work.frames.size()); ++i) {
    (void)made->integrate(work.frames[i].frame, hal::compose(T_map_world, work.frames[i].T_world_camera));
  }
  return made;
}

}  // namespace g3d::test
