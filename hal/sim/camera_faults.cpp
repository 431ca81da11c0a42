// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/camera_faults.hpp"

#include <algorithm>
#include <utility>

#include "hal/frame_pool.hpp"

namespace g3d::hal {
namespace {

constexpr std::uint64_t kEvery = 10;
constexpr std::uint16_t kFarthest_mm = 10'000;

void copy_image(const CameraModel& camera, const Frame& from, Frame& to) {
  std::copy_n(from.depth.get(), camera.pixel_count(), to.depth.get());
  std::copy_n(from.rgb.get(), 3 * camera.pixel_count(), to.rgb.get());
}

}  // namespace

CameraFaults::CameraFaults(const CameraModel& camera, std::uint64_t seed) : camera_(camera), random_(seed) {
  for (std::size_t i = 0; i < kDelay_frames; ++i) kept_.push_back(make_frame(camera));
}

void CameraFaults::set(FaultKind fault) {
  if (fault == fault_) return;
  fault_ = fault;
  since_ = 0;
}

bool CameraFaults::apply(Frame& frame) {
  const std::uint64_t number = since_++;
  switch (fault_) {
    case FaultKind::none:
      return true;
    case FaultKind::off:
      return false;
    case FaultKind::stuck:
      if (number == 0) copy_image(camera_, frame, kept_.front());
      copy_image(camera_, kept_.front(), frame);
      return true;
    case FaultKind::garbage:
      std::generate_n(frame.depth.get(), camera_.pixel_count(),
                      [this] { return static_cast<std::uint16_t>(random_.bits() % kFarthest_mm); });
      return true;
    case FaultKind::wrong:
      std::transform(frame.depth.get(), frame.depth.get() + camera_.pixel_count(), frame.depth.get(),
                     [](std::uint16_t raw) { return static_cast<std::uint16_t>(std::min(raw * 3 / 2, 65535)); });
      return true;
    case FaultKind::slow:
      return number % kEvery == 0;
    case FaultKind::delayed:
      // What goes into the ring now comes out a round later.
      std::swap(frame, kept_[number % kDelay_frames]);
      return number >= kDelay_frames;
    case FaultKind::intermittent:
      return number / kEvery % 2 == 1;
    case FaultKind::count_:
      break;
  }
  return true;
}

}  // namespace g3d::hal
