// SPDX-License-Identifier: Apache-2.0
#include "tests/support/shown_frames.hpp"

#include <algorithm>
#include <cstring>

#include "hal/frame_pool.hpp"
#include "hal/sim/builtin_worlds.hpp"
#include "hal/sim/camera_path.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/sim_renderer.hpp"

namespace g3d::test {
namespace {

const std::size_t kShownPixels = hal::CameraModel{}.pixel_count();

}  // namespace

ShownFrames::ShownFrames(std::size_t count) {
  auto world = hal::load_world("furnished_room");
  hal::SimRenderer renderer(std::move(world).value(), {});
  for (std::size_t i = 0; i < count; ++i) {
    frames_.push_back(hal::make_frame(hal::CameraModel{}));
    renderer.render(hal::camera_pose({0.0, 0.0, 1.0}, 70.0 * static_cast<double>(i), -5.0), 0, i, frames_.back());
  }
}

void ShownFrames::show(std::uint64_t number, hal::Frame& out) const {
  const hal::Frame& from = frame(number);
  std::memcpy(out.depth.get(), from.depth.get(), 2 * kShownPixels);
  std::memcpy(out.rgb.get(), from.rgb.get(), 3 * kShownPixels);
}

bool ShownFrames::is_frame(std::uint64_t number, const hal::Frame& got) const {
  const hal::Frame& wanted = frame(number);
  return std::equal(wanted.depth.get(), wanted.depth.get() + kShownPixels, got.depth.get()) &&
         (!got.has_colour || std::equal(wanted.rgb.get(), wanted.rgb.get() + 3 * kShownPixels, got.rgb.get()));
}

}  // namespace g3d::test
