// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plain_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mapper/cpu/footprint_images.hpp"
#include "mapper/cpu/projective.hpp"
#include "mapper/cpu/visible_blocks.hpp"

namespace g3d::test {

using namespace mapper;
using mapper::cpu::FrameGeometry;
using mapper::cpu::SensorGeometry;

namespace {

std::size_t pixel_at(const hal::CameraModel& camera, int u, int v) {
  return static_cast<std::size_t>(v * camera.width_px + u);
}

/// First reading on the way from (u, v) in steps of (du, dv); 0 if the way leaves the image.
std::uint16_t first_reading(const hal::CameraModel& camera, const std::uint16_t* depth, int u, int v, int du, int dv) {
  while (u >= 0 && v >= 0 && u < camera.width_px && v < camera.height_px) {
    if (depth[pixel_at(camera, u, v)] != 0) return depth[pixel_at(camera, u, v)];
    u += du;
    v += dv;
  }
  return 0;
}

std::array<float, 3> world_point_m(const SensorGeometry& sensor, const FrameGeometry& frame, int u, int v,
                                   std::uint16_t raw) {
  const auto& R = frame.rotation;
  const float z = static_cast<float>(raw) * sensor.metres_per_unit;
  const float slope_u = sensor.column_slope[static_cast<std::size_t>(u)];
  const float slope_v = sensor.row_slope[static_cast<std::size_t>(v)];
  std::array<float, 3> p;
  for (std::size_t a = 0; a < 3; ++a) {
    const float row_part = R[3 * a + 1] * slope_v + R[3 * a + 2];
    p[a] = (row_part + slope_u * R[3 * a]) * z + frame.translation_m[a];
  }
  return p;
}

std::array<std::int32_t, 3> index_of(const SensorGeometry& sensor, const std::array<float, 3>& p) {
  const VoxelIndex v = Grid{sensor.resolution_m}.to_index(p[0], p[1], p[2]);
  return {v.x, v.y, v.z};
}

}  // namespace

std::vector<std::uint16_t> plain_ray_ends(const SensorGeometry& sensor, const std::uint16_t* depth,
                                          std::span<const std::uint16_t> mask, bool carve_invalid) {
  const hal::CameraModel& camera = sensor.camera;
  std::vector<std::uint16_t> ends(camera.pixel_count(), 0);
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const std::size_t i = pixel_at(camera, u, v);
      if (depth[i] >= sensor.near_raw) ends[i] = std::min(depth[i], sensor.far_raw);
      if (depth[i] != 0 || !carve_invalid) continue;
      int nearest = 0;
      for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        const int reading = first_reading(camera, depth, u, v, du, dv);
        if (reading != 0 && (nearest == 0 || reading < nearest)) nearest = reading;
      }
      if (nearest < sensor.near_raw) continue;
      ends[i] = static_cast<std::uint16_t>(std::min({nearest, int{mask[i]}, int{sensor.far_raw}}));
    }
  }
  return ends;
}

bool plain_gives_colour(const hal::CameraModel& camera, const std::uint16_t* depth, int u, int v) {
  const int mine = depth[pixel_at(camera, u, v)];
  for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    const int x = u + du;
    const int y = v + dv;
    if (x < 0 || y < 0 || x >= camera.width_px || y >= camera.height_px) continue;
    const int other = depth[pixel_at(camera, x, y)];
    const int nearer = std::min(mine, other);
    if (std::abs(mine - other) > nearer / 32 + nearer / 128) return false;
  }
  return true;
}

PlainHits plain_hits(const SensorGeometry& sensor, const FrameGeometry& frame, const std::uint16_t* depth) {
  const hal::CameraModel& camera = sensor.camera;
  PlainHits hits;
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const std::size_t i = pixel_at(camera, u, v);
      if (depth[i] < sensor.near_raw || depth[i] > sensor.far_raw) continue;
      const auto k = index_of(sensor, world_point_m(sensor, frame, u, v, depth[i]));
      PlainHit& hit = hits[encode({k[0], k[1], k[2]})];
      if (hit.has_colour || !plain_gives_colour(camera, depth, u, v)) continue;
      hit.has_colour = true;
      hit.pixel = static_cast<std::uint32_t>(i);
    }
  }
  return hits;
}

std::set<MCode> plain_held(const SensorGeometry& sensor, const FrameGeometry& frame, const std::uint16_t* depth) {
  std::set<MCode> held;
  for (int v = 0; v < sensor.camera.height_px; ++v) {
    for (int u = 0; u < sensor.camera.width_px; ++u) {
      const std::uint16_t raw = depth[pixel_at(sensor.camera, u, v)];
      if (raw == 0 || raw >= sensor.near_raw || raw > sensor.far_raw) continue;
      const auto k = index_of(sensor, world_point_m(sensor, frame, u, v, raw));
      held.insert(encode({k[0], k[1], k[2]}));
    }
  }
  return held;
}

namespace {

/// One ray in voxel units, and the indices of the voxels at its ends.
struct RayInGrid {
  std::array<float, 3> start;
  std::array<float, 3> end;
  std::array<std::int32_t, 3> first;
  std::array<std::int32_t, 3> last;
};

/// Amanatides & Woo 1987, with the rules for ties and for the number of steps of kernels/ray_walk.cpp.
std::vector<VoxelIndex> plain_dda(const RayInGrid& ray) {
  std::array<float, 3> t_next;
  std::array<float, 3> t_step;
  std::int32_t steps = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int32_t apart = ray.last[a] - ray.first[a];
    steps += std::abs(apart);
    t_step[a] = 1.0F / (apart != 0 ? std::abs(ray.end[a] - ray.start[a]) : 1.0F);
    const float boundary = static_cast<float>(ray.first[a] - (apart > 0 ? 32767 : 32768));
    const float gap = apart > 0 ? boundary - ray.start[a] : ray.start[a] - boundary;
    t_next[a] = apart != 0 ? gap * t_step[a] : std::numeric_limits<float>::infinity();
  }
  std::vector<VoxelIndex> passed;
  std::array<std::int32_t, 3> at = ray.first;
  for (; steps > 0; --steps) {
    passed.push_back({at[0], at[1], at[2]});
    std::size_t a = t_next[1] <= t_next[2] ? 1 : 2;
    if (t_next[0] <= t_next[1] && t_next[0] <= t_next[2]) a = 0;
    t_next[a] += t_step[a];
    at[a] += ray.last[a] > ray.first[a] ? 1 : -1;
  }
  return passed;
}

/// The thesis's Algorithm 1: the axis with the most steps drives, the others follow when their error term is due.
std::vector<VoxelIndex> plain_bresenham(const RayInGrid& ray) {
  std::array<std::int32_t, 3> n;
  std::array<std::int32_t, 3> sign;
  for (std::size_t a = 0; a < 3; ++a) {
    n[a] = std::abs(ray.last[a] - ray.first[a]);
    sign[a] = ray.last[a] > ray.first[a] ? 1 : -1;
  }
  const std::size_t driving = n[0] >= n[1] && n[0] >= n[2] ? 0 : n[1] >= n[2] ? 1 : 2;
  std::array<std::int32_t, 3> error;
  for (std::size_t a = 0; a < 3; ++a) error[a] = 2 * n[a] - n[driving];
  std::vector<VoxelIndex> passed;
  std::array<std::int32_t, 3> at = ray.first;
  for (std::int32_t step = 0; step < n[driving]; ++step) {
    passed.push_back({at[0], at[1], at[2]});
    at[driving] += sign[driving];
    for (std::size_t a = 0; a < 3; ++a) {
      if (a == driving) continue;
      if (error[a] >= 0) {
        at[a] += sign[a];
        error[a] -= 2 * n[driving];
      }
      error[a] += 2 * n[a];
    }
  }
  return passed;
}

}  // namespace

std::vector<VoxelIndex> plain_ray(const SensorGeometry& sensor, const FrameGeometry& frame, int u, int v,
                                  std::uint16_t end_raw, IntegratorKind kind) {
  RayInGrid ray;
  const auto end_m = world_point_m(sensor, frame, u, v, end_raw);
  for (std::size_t a = 0; a < 3; ++a) {
    ray.start[a] = frame.translation_m[a] / sensor.resolution_m;
    ray.end[a] = end_m[a] / sensor.resolution_m;
  }
  ray.first = index_of(sensor, frame.translation_m);
  ray.last = index_of(sensor, end_m);
  return kind == IntegratorKind::dda ? plain_dda(ray) : plain_bresenham(ray);
}

namespace {

void free_by_rays(const SensorGeometry& sensor, const FrameGeometry& frame, const std::uint16_t* depth,
                  const std::vector<std::uint16_t>& ends, IntegratorKind kind, PlainFree& free) {
  for (int v = 0; v < sensor.camera.height_px; ++v) {
    for (int u = 0; u < sensor.camera.width_px; ++u) {
      const std::size_t i = pixel_at(sensor.camera, u, v);
      if (ends[i] == 0) continue;
      const Seen by = depth[i] != 0 ? Seen::strong : Seen::weak;
      for (const VoxelIndex& voxel : plain_ray(sensor, frame, u, v, ends[i], kind)) {
        Seen& seen = free[encode(voxel)];
        seen = std::max(seen, by);
      }
    }
  }
}

/// A voxel seen face on at the far bound.
float smallest_window_px(const SensorGeometry& sensor) {
  const float far_m = static_cast<float>(sensor.far_raw) * sensor.metres_per_unit;
  return cpu::ProjectiveTuning{}.window_scale * sensor.camera.fx_px * sensor.resolution_m / far_m;
}

/// The square of pixels that a voxel covers, and the depth that a ray must reach there.
class Footprints {
 public:
  Footprints(const SensorGeometry& sensor, const FrameGeometry& frame)
      : sensor_(sensor),
        frame_(frame),
        numbers_(cpu::projective_frame(sensor, frame, {})),
        choices_(sensor.camera.width_px, sensor.camera.height_px, smallest_window_px(sensor)) {}

  [[nodiscard]] Seen look(const VoxelIndex& voxel, const std::uint16_t* depth,
                          const std::vector<std::uint16_t>& ends) const {
    const hal::CameraModel& camera = sensor_.camera;
    // The camera-frame position is that of the block's first voxel plus an offset, as in the block-wise integrator:
    // another order of additions would round differently.
    const auto block_m = cpu::voxel_in_camera_m(sensor_, frame_, {voxel.x & ~7, voxel.y & ~7, voxel.z & ~7});
    const auto offset_m = offset(voxel.x & 7, voxel.y & 7, voxel.z & 7);
    const float block_units = camera.depth_units_per_metre * block_m[2];
    const float z_units = block_units + camera.depth_units_per_metre * offset_m[2];
    const float x_px_m = camera.fx_px * block_m[0] + camera.fx_px * offset_m[0];
    const float y_px_m = camera.fy_px * block_m[1] + camera.fy_px * offset_m[1];
    if (z_units < numbers_.min_z_units || !reaches_into_image(x_px_m, y_px_m, z_units)) return Seen::no;

    // The window's size goes by the depth of the middle of the 4 x 4 x 4 voxels around.
    const float low = camera.depth_units_per_metre * offset(voxel.x & 4, voxel.y & 4, voxel.z & 4)[2];
    const float high =
        camera.depth_units_per_metre * offset((voxel.x & 4) + 3, (voxel.y & 4) + 3, (voxel.z & 4) + 3)[2];
    const float middle_units = std::max(block_units + 0.5F * (low + high), numbers_.min_z_units);
    const auto choice = choices_.choose(numbers_.window_px_m / (middle_units * sensor_.metres_per_unit));

    const float cells_per_px = 1.0F / static_cast<float>(1 << choice.level);
    const float inverse = cells_per_px / (z_units * sensor_.metres_per_unit);
    const float begin = 0.5F - 0.5F * static_cast<float>(choice.window_cells) + static_cast<float>(cpu::kImagePadding);
    const auto& level = choices_.level(choice.level);
    const float x = x_px_m * inverse + ((camera.cx_px + 0.5F) * cells_per_px + begin);
    const float y = y_px_m * inverse + ((camera.cy_px + 0.5F) * cells_per_px + begin);
    const int u0 = first_px(x, level.width, choice);
    const int v0 = first_px(y, level.height, choice);
    const int side = choice.window_cells << choice.level;
    // Ends of far readings are no surface: against them another bias counts.
    const float beyond_units = z_units + numbers_.bias_units;
    const bool far_counts = z_units + numbers_.far_bias_units <= numbers_.far_units;
    const float needed_units = far_counts ? std::min(beyond_units, numbers_.far_units) : beyond_units;
    Seen seen = Seen::no;
    for (int v = std::max(v0, 0); v < std::min(v0 + side, camera.height_px); ++v) {
      for (int u = std::max(u0, 0); u < std::min(u0 + side, camera.width_px); ++u) {
        const std::size_t i = pixel_at(camera, u, v);
        if (static_cast<float>(ends[i]) < needed_units) continue;
        seen = std::max(seen, depth[i] != 0 ? Seen::strong : Seen::weak);
      }
    }
    return seen;
  }

 private:
  [[nodiscard]] std::array<float, 3> offset(int vx, int vy, int vz) const {
    const auto& R = frame_.rotation;
    const float x = static_cast<float>(vx) * sensor_.resolution_m;
    const float y = static_cast<float>(vy) * sensor_.resolution_m;
    const float z = static_cast<float>(vz) * sensor_.resolution_m;
    return {R[0] * x + R[3] * y + R[6] * z, R[1] * x + R[4] * y + R[7] * z, R[2] * x + R[5] * y + R[8] * z};
  }
  /// Does the voxel reach across the planes through the camera and the centres of the outermost pixels?
  [[nodiscard]] bool reaches_into_image(float x_px_m, float y_px_m, float z_units) const {
    const float z_m = z_units * sensor_.metres_per_unit;
    return x_px_m + numbers_.reach_px_m[0] >= numbers_.left_px * z_m &&
           x_px_m - numbers_.reach_px_m[1] <= numbers_.right_px * z_m &&
           y_px_m + numbers_.reach_px_m[2] >= numbers_.top_px * z_m &&
           y_px_m - numbers_.reach_px_m[3] <= numbers_.bottom_px * z_m;
  }
  /// First pixel of a window that begins at a cell (padding included); the window always meets the image.
  static int first_px(float cell, int cells, cpu::FootprintImages::Choice choice) {
    const auto first = static_cast<float>(cpu::kImagePadding + 1 - choice.window_cells);
    const auto last = static_cast<float>(cpu::kImagePadding + cells - 1);
    return (static_cast<int>(std::min(std::max(cell, first), last)) - cpu::kImagePadding) * (1 << choice.level);
  }

  const SensorGeometry& sensor_;
  const FrameGeometry& frame_;
  cpu::ProjectiveFrame numbers_;
  cpu::FootprintImages choices_;
};

void free_by_projection(const SensorGeometry& sensor, const FrameGeometry& frame, const std::uint16_t* depth,
                        const std::vector<std::uint16_t>& ends, PlainFree& free) {
  const Footprints footprints(sensor, frame);
  for (int z = 0; z < 8 * frame.nz_blocks; ++z) {
    for (int y = 0; y < 8 * frame.ny_blocks; ++y) {
      for (int x = 0; x < 8 * frame.nx_blocks; ++x) {
        const VoxelIndex voxel{frame.origin.x + x, frame.origin.y + y, frame.origin.z + z};
        const Seen seen = footprints.look(voxel, depth, ends);
        if (seen != Seen::no) free[encode(voxel)] = seen;
      }
    }
  }
}

}  // namespace

PlainFree plain_free(const SensorGeometry& sensor, const FrameGeometry& frame, const std::uint16_t* depth,
                     const std::vector<std::uint16_t>& ends, IntegratorKind kind) {
  PlainFree free;
  if (kind == IntegratorKind::projective) {
    free_by_projection(sensor, frame, depth, ends, free);
  } else {
    free_by_rays(sensor, frame, depth, ends, kind, free);
  }
  return free;
}

}  // namespace g3d::test
