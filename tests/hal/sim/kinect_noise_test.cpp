// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/kinect_noise.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "hal/sim/sim_building.hpp"

using namespace g3d::hal;

namespace {

constexpr std::uint8_t kFrontal = 127;

struct Spoilt {
  CameraModel camera;
  ExactView view{camera};
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(camera.pixel_count());

  explicit Spoilt(float depth_m, std::uint8_t surface = kFrontal) {
    std::fill(view.depth_m.begin(), view.depth_m.end(), depth_m);
    std::fill(view.surface.begin(), view.surface.end(), surface);
  }
  void run(std::uint64_t frame = 0, std::uint64_t seed = 1, int threads = 1) {
    RowWorkers workers(threads);
    KinectNoise(camera, seed).apply(view, frame, workers, depth.data());
  }
  [[nodiscard]] double invalid() const {
    return static_cast<double>(std::count(depth.begin(), depth.end(), 0)) / static_cast<double>(depth.size());
  }
};

}  // namespace

TEST_CASE("a flat wall has the range noise and the speckle of the model, without bias") {
  for (const float z_m : {0.9F, 1.5F, 2.5F, 3.5F}) {
    CAPTURE(z_m);
    Spoilt wall(z_m);
    wall.run();
    CHECK(wall.invalid() == Approx(0.005).margin(0.001));
    double sum = 0.0;
    double squares = 0.0;
    std::size_t n = 0;
    for (const std::uint16_t raw : wall.depth) {
      if (raw == 0) continue;
      const double error_m = raw / 1000.0 - static_cast<double>(z_m);
      sum += error_m;
      squares += error_m * error_m;
      ++n;
    }
    const double mean_m = sum / static_cast<double>(n);
    const double sigma_m = std::sqrt(squares / static_cast<double>(n) - mean_m * mean_m);
    const double model_m = 0.0012 + 0.0019 * (z_m - 0.4) * (z_m - 0.4);
    const double step_m = z_m * z_m / (580.0 * 0.075 * 8.0);
    CHECK(std::abs(mean_m) < 0.35 * step_m);
    CHECK(sigma_m > 0.5 * model_m);
    CHECK(sigma_m < model_m + 0.5 * step_m);
  }
}

TEST_CASE("readings fall on the steps of an eighth of a pixel of disparity") {
  Spoilt wall(3.0F);
  wall.run();
  std::set<std::uint16_t> values(wall.depth.begin(), wall.depth.end());
  values.erase(0);
  CHECK(values.size() < 12);
  CHECK(values.size() > 3);
  for (const std::uint16_t raw : values) {
    const double steps = 580.0 * 0.075 * 8.0 / (raw / 1000.0);
    CHECK(std::abs(steps - std::round(steps)) < 0.03);
  }
}

TEST_CASE("too near, too far, dark and grazing surfaces give no reading") {
  Spoilt near(0.49F);
  near.run();
  CHECK(near.invalid() == 1.0);
  Spoilt far(8.1F);
  far.run();
  CHECK(far.invalid() == 1.0);
  Spoilt nothing(0.0F);
  nothing.run();
  CHECK(nothing.invalid() == 1.0);
  Spoilt dark(2.0F, kFrontal | ExactView::kDark);
  dark.run();
  CHECK(dark.invalid() == 1.0);
  Spoilt grazing(2.0F, 5);  // cosine 0.04
  grazing.run();
  CHECK(grazing.invalid() == 1.0);
  Spoilt slanted(2.0F, 10);  // cosine 0.079: about half
  slanted.run();
  CHECK(slanted.invalid() > 0.3);
  CHECK(slanted.invalid() < 0.7);
}

TEST_CASE("a near thing throws an infrared shadow to its left") {
  Spoilt scene(3.0F);
  const std::size_t width = 640;
  for (std::size_t v = 0; v < 480; ++v) {
    for (std::size_t u = 300; u < 340; ++u) scene.view.depth_m[v * width + u] = 1.5F;
  }
  scene.run();
  const auto invalid_in_column = [&](std::size_t u) {
    std::size_t n = 0;
    for (std::size_t v = 0; v < 480; ++v) n += scene.depth[v * width + u] == 0 ? 1 : 0;
    return static_cast<double>(n) / 480.0;
  };
  // 525 px * 0.075 m * (1 / 1.5 m - 1 / 3 m) = 13.1 px
  for (std::size_t u = 288; u < 300; ++u) CHECK(invalid_in_column(u) == 1.0);
  CHECK(invalid_in_column(285) < 0.05);
  CHECK(invalid_in_column(320) < 0.05);
  CHECK(invalid_in_column(345) < 0.05);
  // Ragged outline on the other side.
  CHECK(invalid_in_column(339) > 0.15);
  CHECK(invalid_in_column(339) < 0.5);
}

TEST_CASE("outlines are as sharp in a coarse image as in the sensor's own") {
  const auto spoilt_at_edges = [](int width_px, int height_px) {
    Spoilt step(3.0F);
    step.camera = scaled_kinect(width_px, height_px);
    step.view = ExactView(step.camera);
    step.depth.resize(step.camera.pixel_count());
    std::fill(step.view.surface.begin(), step.view.surface.end(), kFrontal);
    // The near half is on the left, which throws no shadow on what is seen of the far one.
    const auto width = static_cast<std::size_t>(width_px);
    for (std::size_t i = 0; i < step.view.depth_m.size(); ++i)
      step.view.depth_m[i] = i % width < width / 2 ? 1.5F : 3.0F;
    int missing = 0;
    int moved = 0;
    int all = 0;
    for (std::uint64_t frame = 0; frame < 40; ++frame) {
      step.run(frame);
      for (std::size_t row = 0; row < static_cast<std::size_t>(height_px); ++row) {
        const int left = step.depth[row * width + width / 2 - 1];
        const int right = step.depth[row * width + width / 2];
        missing += (left == 0 ? 1 : 0) + (right == 0 ? 1 : 0);
        moved += (left > 2300 ? 1 : 0) + (right != 0 && right < 2300 ? 1 : 0);
        all += 2;
      }
    }
    return std::array{missing / static_cast<double>(all), moved / static_cast<double>(all)};
  };
  const auto fine = spoilt_at_edges(640, 480);
  CHECK(fine[0] == Approx(0.005 + 0.30).margin(0.02));
  CHECK(fine[1] == Approx(0.70 * 0.25 / 2).margin(0.01));
  const auto coarse = spoilt_at_edges(160, 120);
  CHECK(coarse[0] == Approx(0.005 + 0.30 / 4).margin(0.01));
  CHECK(coarse[1] == Approx(0.925 * 0.25 / 4 / 2).margin(0.006));
}

TEST_CASE("noise depends on seed and frame, not on threads", "[threads]") {
  Spoilt a(2.0F);
  Spoilt b(2.0F);
  a.run(5, 1, 1);
  b.run(5, 1, 3);
  CHECK(a.depth == b.depth);
  b.run(6, 1, 1);
  CHECK(a.depth != b.depth);
  b.run(5, 2, 1);
  CHECK(a.depth != b.depth);
}

TEST_CASE("exact depth is rounded to raw units, and left out where it does not fit") {
  CameraModel camera;
  ExactView view(camera);
  view.depth_m[0] = 1.2344F;
  view.depth_m[1] = 1.2346F;
  view.depth_m[2] = 70.0F;
  std::vector<std::uint16_t> depth(camera.pixel_count(), 7);
  write_exact_depth(view, camera, depth.data());
  CHECK(depth[0] == 1234);
  CHECK(depth[1] == 1235);
  CHECK(depth[2] == 0);
  CHECK(depth[3] == 0);
}
