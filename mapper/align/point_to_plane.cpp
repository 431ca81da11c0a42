// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/point_to_plane.hpp"

namespace g3d::mapper::align {

NormalSums match(std::span<const DepthSample> samples, const SurfaceMap& surfaces, const hal::Pose& T_world_camera,
                 float kernel_m, hal::TimeNs born_by_ns) {
  NormalSums sums;
  const hal::RigidTransform T = hal::to_transform(T_world_camera);
  const auto look_up = [&](std::uint64_t key) { return surfaces.look_up(key); };
  for (const DepthSample& sample : samples) {
    add_match(sample, T, surfaces.options().rule, kernel_m, born_by_ns, look_up, sums);
  }
  return sums;
}

FitAnswer fit(std::span<const DepthSample> samples, const SurfaceMap& surfaces, const FitQuestion& question) {
  FitAnswer answer;
  answer.pose = question.predicted;
  for (int step = 0;; ++step) {
    answer.last = match(samples, surfaces, answer.pose, question.kernel_m, question.born_by_ns);
    if (step == 0) answer.first = answer.last;
    if (!take_step(answer.last, static_cast<double>(samples.size()), question, step, answer.pose)) return answer;
  }
}

}  // namespace g3d::mapper::align
