// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sim_renderer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/sim/camera_path.hpp"
#include "hal/sim/load_world.hpp"

using namespace g3d::hal;

TEST_CASE("a frame carries stamp, sequence, colour and either exact or spoilt depth", "[threads]") {
  const World world = load_world("furnished_room").value();
  const Pose pose = camera_pose({2.5, 0, 0.5}, 90, 0);
  SimRendererOptions options;
  options.threads = 2;
  SimRenderer noisy(world, options);
  options.noise = false;
  SimRenderer exact(world, options);
  Frame a = make_frame(options.camera);
  Frame b = make_frame(options.camera);
  noisy.render(pose, 1234, 77, a);
  exact.render(pose, 1234, 77, b);
  CHECK(a.stamp_ns == 1234);
  CHECK(a.sequence == 77);
  CHECK(a.has_colour);
  const std::size_t n = options.camera.pixel_count();
  CHECK(std::equal(a.rgb.get(), a.rgb.get() + 3 * n, b.rgb.get()));
  std::size_t differ = 0;
  for (std::size_t i = 0; i < n; ++i) {
    REQUIRE(b.depth[i] == static_cast<std::uint16_t>(exact.exact().depth_m[i] * 1000.0F + 0.5F));
    differ += a.depth[i] != b.depth[i] ? 1 : 0;
  }
  CHECK(differ > n / 2);
}
