// SPDX-License-Identifier: Apache-2.0
// The exact map (`dda`) against liboctomap's insertPointCloud(discretize=false) on the same points and ray ends, with
// OctoMap's steps and clamps set to ours and pixels without a reading omitted for both.
//   faithful_bench [--frames N] [--resolution METRES]... [--log FOLDER]...
#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "mapper/mapper.hpp"
#include "tests/support/octomap_twin.hpp"
#include "tests/support/ray_list.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;

namespace {

bool run(const test::Workload& work, float resolution_m) {
  mapper::MapperConfig config;
  config.resolution_m = resolution_m;
  config.integrator = mapper::IntegratorKind::dda;
  config.carve_invalid = false;
  config.with_colour = false;
  config.capacity = mapper::capacity_for_bytes(std::size_t{1024} << 20);
  mapper::Mapper ours(config, work.camera);
  test::OctomapTwin theirs(resolution_m);
  for (const test::PosedImage& image : work.frames) {
    (void)ours.integrate(image.frame, image.T_world_camera);
    theirs.integrate(test::ray_list(work.camera, image.frame.depth.get(), image.T_world_camera));
  }
  const test::Agreement agreement = theirs.compare(ours.map());
  fmt::print("{:22} r={:.3f} frames={:3} agree {:.4f} %  {}\n", work.name, resolution_m, work.frames.size(),
             100.0 * agreement.share(), test::describe(agreement));
  std::fflush(stdout);
  return agreement.share() >= 0.995;
}

}  // namespace

int main(int argc, char** argv) {
  int frames = 20;
  std::vector<float> resolutions_m;
  std::vector<std::string> logs;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--frames") == 0) frames = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--resolution") == 0) resolutions_m.push_back(static_cast<float>(std::atof(argv[i + 1])));
    if (std::strcmp(argv[i], "--log") == 0) logs.emplace_back(argv[i + 1]);
  }
  if (resolutions_m.empty()) resolutions_m = {0.05F, 0.02F};
  bool all_agree = true;
  for (const float r : resolutions_m) {
    all_agree &= run(test::simulated_drive("furnished_room", frames, 60.0 / frames), r);
    for (const std::string& log : logs) all_agree &= run(test::recorded(log, static_cast<std::size_t>(frames)), r);
  }
  return all_agree ? 0 : 1;
}
