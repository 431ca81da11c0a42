// SPDX-License-Identifier: Apache-2.0
#include "tests/support/workload.hpp"

#include <cmath>

#include "hal/frame_pool.hpp"
#include "hal/replay/recorded_poses.hpp"
#include "hal/replay/replay_camera.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/sim_renderer.hpp"

namespace g3d::test {

Workload simulated_drive(const std::string& builtin, int count, double step_s, double start_s, int width_px,
                         bool noise) {
  Workload work;
  work.name = builtin;
  const float scale = static_cast<float>(width_px) / 640.0F;
  work.camera = {width_px, width_px * 3 / 4, 525.0F * scale, 525.0F * scale, 319.5F * scale, 239.5F * scale, 1000.0F};
  auto world = hal::load_world(builtin);
  auto path = hal::load_camera_path(builtin);
  if (!world || !path) return work;
  hal::SimRendererOptions options;
  options.camera = work.camera;
  options.noise = noise;
  options.threads = 2;
  hal::SimRenderer renderer(std::move(world).value(), options);
  for (int i = 0; i < count; ++i) {
    const auto t_ns = static_cast<hal::TimeNs>((start_s + i * step_s) * 1e9) + path.value().begin_ns();
    if (t_ns > path.value().end_ns()) break;
    PosedImage image{hal::make_frame(work.camera), path.value().pose_at(t_ns)};
    renderer.render(image.T_world_camera, t_ns, static_cast<std::uint64_t>(i), image.frame);
    work.frames.push_back(std::move(image));
  }
  return work;
}

Workload recorded(const std::string& folder, std::size_t count) {
  Workload work;
  work.name = folder.substr(folder.find_last_of('/') + 1);
  auto camera = hal::ReplayCamera::open(folder);
  auto poses = hal::RecordedPoses::open(folder);
  if (!camera || !poses) return work;
  work.camera = camera.value()->model();
  while (work.frames.size() < count) {
    PosedImage image{hal::make_frame(work.camera), {}};
    const hal::CameraRead read = camera.value()->read(image.frame);
    if (read.event == hal::CameraEvent::end) break;
    if (read.event != hal::CameraEvent::frame) continue;
    if (poses.value()->pose_at(image.frame.stamp_ns, image.T_world_camera) != hal::PoseStatus::ok) continue;
    work.frames.push_back(std::move(image));
  }
  return work;
}

}  // namespace g3d::test
