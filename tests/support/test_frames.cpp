// SPDX-License-Identifier: Apache-2.0
#include "tests/support/test_frames.hpp"

#include <algorithm>

#include "hal/frame_pool.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/temp_folder.hpp"

namespace g3d::test {

hal::CameraModel small_camera(int width_px) {
  hal::CameraModel camera;
  const float scale = static_cast<float>(width_px) / 640.0F;
  camera.width_px = width_px;
  camera.height_px = width_px * 3 / 4;
  camera.fx_px = 525.0F * scale;
  camera.fy_px = 524.0F * scale;
  camera.cx_px = 0.5F * static_cast<float>(camera.width_px) - 0.7F;
  camera.cy_px = 0.5F * static_cast<float>(camera.height_px) - 0.3F;
  return camera;
}

hal::Frame random_frame(const hal::CameraModel& camera, std::uint64_t seed) {
  tests::Random random(seed);
  hal::Frame frame = hal::make_frame(camera);
  frame.has_colour = true;
  const int width = camera.width_px;
  const int height = camera.height_px;
  const double base_m = random.uniform(0.6, 4.2);
  const double tilt_u = random.uniform(-1.5, 1.5) / width;
  const double tilt_v = random.uniform(-1.5, 1.5) / height;
  const double noise_m = random.below(3) == 0 ? 1.0 : 0.01;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double z_m = base_m + tilt_u * u + tilt_v * v + noise_m * random.uniform(-1.0, 1.0);
      const double raw = std::clamp(z_m * static_cast<double>(camera.depth_units_per_metre), 1.0, 60000.0);
      frame.depth[static_cast<std::size_t>(v * width + u)] = static_cast<std::uint16_t>(raw);
    }
  }
  const auto paint = [&](int u0, int v0, int u1, int v1, std::uint16_t raw) {
    for (int v = std::max(v0, 0); v < std::min(v1, height); ++v) {
      for (int u = std::max(u0, 0); u < std::min(u1, width); ++u)
        frame.depth[static_cast<std::size_t>(v * width + u)] = raw;
    }
  };
  // Things in front, things far away, things too near, and holes; some of them hang over the border.
  for (int i = 0; i < 24; ++i) {
    const int u = static_cast<int>(random.below(static_cast<std::uint32_t>(width + 16))) - 8;
    const int v = static_cast<int>(random.below(static_cast<std::uint32_t>(height + 16))) - 8;
    const int w = 1 + static_cast<int>(random.below(static_cast<std::uint32_t>(width / 3)));
    const int h = 1 + static_cast<int>(random.below(static_cast<std::uint32_t>(height / 3)));
    const double depth_m = std::array<double, 4>{0.0, 0.6, 2.1, 5.0}[random.below(4)];
    paint(u, v, u + w, v + h, static_cast<std::uint16_t>(depth_m * static_cast<double>(camera.depth_units_per_metre)));
  }
  for (std::size_t i = 0; i < camera.pixel_count(); ++i) {
    if (random.below(50) == 0) frame.depth[i] = 0;
  }
  for (std::size_t i = 0; i < 3 * camera.pixel_count(); ++i)
    frame.rgb[i] = static_cast<std::uint8_t>(random.below(256));
  return frame;
}

hal::Pose random_pose(std::uint64_t seed) {
  tests::Random random(seed ^ 0x5EED);
  const auto angle = [&] { return random.uniform(-3.14, 3.14); };
  const auto place = [&] { return random.uniform(-3.0, 3.0); };
  const double x_m = place();
  const double y_m = place();
  const double z_m = place();
  const double roll = angle();
  const double pitch = angle();
  return hal::from_xyz_rpy(x_m, y_m, z_m, roll, pitch, angle());
}

std::vector<PosedImage> random_frames(const hal::CameraModel& camera, int count, std::uint64_t seed) {
  std::vector<PosedImage> frames;
  hal::Pose pose = random_pose(seed);
  for (int i = 0; i < count; ++i) {
    // Mostly the same view again, so that voxels are seen, hit and lost more than once.
    if (i % 4 == 3) pose = random_pose(seed + static_cast<std::uint64_t>(i));
    frames.push_back({random_frame(camera, 100 * seed + static_cast<std::uint64_t>(i)), pose});
  }
  return frames;
}

namespace {

PosedImage thinned(const PosedImage& full, const hal::CameraModel& from, const hal::CameraModel& to, int thin) {
  PosedImage small{hal::make_frame(to), full.T_world_camera};
  small.frame.stamp_ns = full.frame.stamp_ns;
  small.frame.has_colour = full.frame.has_colour;
  for (int v = 0; v < to.height_px; ++v) {
    for (int u = 0; u < to.width_px; ++u) {
      const auto target = static_cast<std::size_t>(v * to.width_px + u);
      const auto source = static_cast<std::size_t>(v * thin * from.width_px + u * thin);
      small.frame.depth[target] = full.frame.depth[source];
      for (std::size_t c = 0; c < 3; ++c) small.frame.rgb[3 * target + c] = full.frame.rgb[3 * source + c];
    }
  }
  return small;
}

}  // namespace

Workload thinned(const Workload& full, std::size_t every, int thin) {
  Workload small;
  small.name = full.name;
  small.camera = full.camera;
  small.camera.width_px /= thin;
  small.camera.height_px /= thin;
  for (float* number : {&small.camera.fx_px, &small.camera.fy_px, &small.camera.cx_px, &small.camera.cy_px}) {
    *number /= static_cast<float>(thin);
  }
  for (std::size_t i = 0; i < full.frames.size(); i += every) {
    small.frames.push_back(thinned(full.frames[i], full.camera, small.camera, thin));
  }
  return small;
}

Workload thinned_recording(const std::string& name, std::size_t count, std::size_t every, int thin) {
  const std::string data = data_folder();
  if (data.empty()) return {};
  return thinned(recorded(data + "/" + name, (count - 1) * every + 1), every, thin);
}

}  // namespace g3d::test
