// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sim_renderer.hpp"

#include <algorithm>
#include <utility>

namespace g3d::hal {

SimRenderer::SimRenderer(World world, const SimRendererOptions& options)
    : SimRenderer(std::make_shared<const World>(std::move(world)), options) {}

SimRenderer::SimRenderer(std::shared_ptr<const World> world, const SimRendererOptions& options)
    : world_(std::move(world)),
      options_(options),
      caster_(*world_, options.camera, options.threads),
      noise_(options.camera, options.seed),
      view_(options.camera) {}

void SimRenderer::render(const Pose& T_world_camera, TimeNs time_ns, std::uint64_t sequence, Frame& out) {
  caster_.render(T_world_camera, time_ns, view_);
  finish(time_ns, sequence, out);
}

void SimRenderer::render(const Pose& T_world_camera, TimeNs time_ns, std::uint64_t sequence, MoverPlaces places_m,
                         std::int32_t hidden, Frame& out) {
  caster_.render(T_world_camera, places_m, hidden, view_);
  finish(time_ns, sequence, out);
}

void SimRenderer::finish(TimeNs time_ns, std::uint64_t sequence, Frame& out) {
  if (options_.noise) {
    noise_.apply(view_, sequence, caster_.workers(), out.depth.get());
  } else {
    write_exact_depth(view_, options_.camera, out.depth.get());
  }
  std::copy(view_.rgb.begin(), view_.rgb.end(), out.rgb.get());
  out.has_colour = true;
  out.stamp_ns = time_ns;
  out.sequence = sequence;
}

}  // namespace g3d::hal
