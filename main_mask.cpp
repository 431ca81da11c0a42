// SPDX-License-Identifier: Apache-2.0
// `g3dmap mask`: a free scan mask out of a recorded wall view.
#include <fmt/format.h>

#include "hal/frame_pool.hpp"
#include "hal/replay/replay_camera.hpp"
#include "main_commands.hpp"
#include "main_say.hpp"
#include "mapper/scan_mask.hpp"

namespace g3d {
namespace {

// Below, the recording shows no wall that fills the view.
constexpr double kLeastMaskCoverage = 0.5;

}  // namespace

int run_mask(const MaskOptions& options) {
  auto camera = hal::ReplayCamera::open(options.log_dir);
  if (!camera) return fail(camera.error().text);
  const hal::CameraModel& model = camera.value()->model();
  mapper::ScanMaskBuilder builder(model);
  hal::Frame frame = hal::make_frame(model);
  std::size_t frames = 0;
  for (auto read = camera.value()->read(frame); read.event != hal::CameraEvent::end;
       read = camera.value()->read(frame)) {
    if (read.event != hal::CameraEvent::frame) continue;
    builder.add(frame);
    ++frames;
  }
  if (builder.coverage() < kLeastMaskCoverage) {
    return fail(
        fmt::format("{}: only {:.0f} % of the pixels ever gave a reading in {} frames; record a plain wall that "
                    "fills the view, about 3 m away",
                    options.log_dir, 100.0 * builder.coverage(), frames));
  }
  if (const auto saved = mapper::save_scan_mask(options.out, model, builder.mask()); !saved)
    return fail(saved.error().text);
  fmt::print("{}  from {} frames, {:.1f} % of the pixels may carve\n", options.out, frames, 100.0 * builder.coverage());
  return kExitDone;
}

}  // namespace g3d
