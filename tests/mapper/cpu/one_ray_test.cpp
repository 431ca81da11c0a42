// SPDX-License-Identifier: Apache-2.0
// One ray asked about one voxel, against the plain walk's list of voxels; and the bound on rounding against geometry in
// double precision.
#include "mapper/cpu/one_ray.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "mapper/morton.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

namespace {

struct View {
  hal::CameraModel camera;
  SensorGeometry sensor;
  FrameGeometry frame;
  hal::Frame image;
  ThreadPool pool{1};
  RayEnds ends;
  std::vector<float> slopes;
  RaySearch search;

  View(int width_px, float resolution_m, const hal::Pose& pose, std::uint64_t seed)
      : camera(test::small_camera(width_px)),
        sensor(camera, resolution_m, 0.8F, 3.5F),
        frame(frame_geometry(sensor, hal::to_transform(pose)).value()),
        image(test::random_frame(camera, seed)),
        ends(sensor, {}, 3000, true),
        slopes(sensor.column_slope) {
    slopes.resize(slopes.size() + kRayLanes, 0.0F);
    ends.compute(image.depth.get(), best_kernels(), pool);
    search = ray_search(sensor, frame, ends, slopes.data());
  }
  [[nodiscard]] std::set<MCode> passed_by(int u, int v) const {
    std::set<MCode> codes;
    if (ends.at(u, v) == 0) return codes;
    for (const VoxelIndex& voxel : test::plain_ray(sensor, frame, u, v, ends.at(u, v), IntegratorKind::dda))
      codes.insert(encode(voxel));
    return codes;
  }
  [[nodiscard]] VoxelIndex own_voxel() const {
    return Grid{sensor.resolution_m}.to_index(frame.translation_m[0], frame.translation_m[1], frame.translation_m[2]);
  }
};

}  // namespace

TEST_CASE("a ray passes the voxels of its plain walk and no neighbour of them") {
  std::size_t yes = 0;
  std::size_t no = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    hal::Pose pose = test::random_pose(seed);
    if (seed % 2 == 1) pose.translation_m = {0.5, -1.0, 0.25};  // a corner of voxels
    const View view(40, 0.05F, pose, seed);
    for (int u = 0; u < view.camera.width_px; u += 5) {
      for (int v = 0; v < view.camera.height_px; v += 7) {
        const std::set<MCode> passed = view.passed_by(u, v);
        std::set<MCode> around;
        for (const MCode code : passed) {
          const VoxelIndex k = decode(code);
          for (int n = 0; n < 27; ++n) around.insert(encode({k.x + n % 3 - 1, k.y + n / 3 % 3 - 1, k.z + n / 9 - 1}));
        }
        for (const MCode code : around) {
          const VoxelIndex k = decode(code);
          const std::int32_t voxel[3] = {k.x, k.y, k.z};
          const bool expected = passed.contains(code);
          (expected ? yes : no) += 1;
          REQUIRE(walk_passes(view.search, u, v, view.ends.at(u, v), voxel) == expected);
        }
      }
    }
  }
  CHECK(yes > 5000);
  CHECK(no > 50000);
}

TEST_CASE("bundles say of the voxels around the camera what their rays say one by one", "[slow]") {
  int yes = 0;
  int no = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    hal::Pose pose = test::random_pose(seed);
    for (std::size_t a = 0; a < 3; ++a) {  // exactly on a border of voxels along some axes, or next to it
      if ((seed >> a & 1U) != 0) pose.translation_m[a] = std::round(pose.translation_m[a] / 0.0625) * 0.0625;
      if (seed >= 16) pose.translation_m[a] += 1e-7 * (static_cast<double>(a) - 1.0);
    }
    const View view(40, 0.0625F, pose, seed);
    std::set<MCode> strong;
    std::set<MCode> any;
    for (int v = 0; v < view.camera.height_px; ++v) {
      for (int u = 0; u < view.camera.width_px; ++u) {
        const std::set<MCode> passed = view.passed_by(u, v);
        any.insert(passed.begin(), passed.end());
        if (view.ends.is_strong(u, v)) strong.insert(passed.begin(), passed.end());
      }
    }
    const VoxelIndex own = view.own_voxel();
    for (int n = 0; n < 27; ++n) {
      const std::int32_t voxel[3] = {own.x + n % 3 - 1, own.y + n / 3 % 3 - 1, own.z + n / 9 - 1};
      const MCode code = encode({voxel[0], voxel[1], voxel[2]});
      (any.contains(code) ? yes : no) += 1;
      CHECK(any_walk_passes(view.search, voxel, false) == any.contains(code));
      CHECK(any_walk_passes(view.search, voxel, true) == strong.contains(code));
    }
  }
  CHECK(yes > 50);
  CHECK(no > 200);
}

TEST_CASE("no walk strays farther from its line than the bound says") {
  for (const double offset_m : {0.0, 1400.0}) {
    double worst = 0;  // share of the bound
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      hal::Pose pose = test::random_pose(seed);
      pose.translation_m[seed % 3] += offset_m;
      const View view(40, 0.05F, pose, seed);
      const double bound = double{walk_error_cells(view.sensor, view.frame)};
      for (int u = 0; u < view.camera.width_px; u += 3) {
        const int v = (u * 7) % view.camera.height_px;
        std::array<double, 3> from;
        std::array<double, 3> along;
        const std::array<double, 3> slope{(u - double{view.camera.cx_px}) / double{view.camera.fx_px},
                                          (v - double{view.camera.cy_px}) / double{view.camera.fy_px}, 1};
        for (std::size_t a = 0; a < 3; ++a) {
          from[a] = double{view.frame.translation_m[a]} / double{view.sensor.resolution_m};
          along[a] = 0;
          for (std::size_t b = 0; b < 3; ++b) along[a] += double{view.frame.rotation[3 * a + b]} * slope[b];
        }
        for (const MCode code : view.passed_by(u, v)) {
          // How much larger must the voxel be for the line to cut it? Separating axes: the line's cross products.
          const VoxelIndex k = decode(code);
          const std::array<double, 3> c{k.x - 32767.5 - from[0], k.y - 32767.5 - from[1], k.z - 32767.5 - from[2]};
          double missing = 0;
          for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t b = (a + 1) % 3;
            const std::size_t d = (a + 2) % 3;
            const double across = std::abs(c[b] * along[d] - c[d] * along[b]);
            missing = std::max(missing, across / (std::abs(along[b]) + std::abs(along[d])) - 0.5);
          }
          worst = std::max(worst, missing / bound);
        }
      }
    }
    INFO("worst share of the bound " << worst);
    CHECK(worst <= 1.0);
    CHECK(worst > (offset_m > 0 ? 0.01 : 0.0));  // there is something to bound
  }
}
