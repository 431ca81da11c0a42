// SPDX-License-Identifier: Apache-2.0
// A camera without a world: numbered frames of one colour at an even pace, until it is stopped.
#pragma once

#include <algorithm>
#include <atomic>

#include "hal/clock.hpp"
#include "hal/depth_camera.hpp"

namespace g3d::test {

class TickingCamera final : public hal::DepthCamera {
 public:
  TickingCamera(hal::Clock& clock, int width_px, int height_px, hal::TimeNs period_ns)
      : clock_(clock), period_ns_(period_ns), next_ns_(clock.now()) {
    model_.width_px = width_px;
    model_.height_px = height_px;
    model_.cx_px = static_cast<float>(width_px - 1) / 2.0F;
    model_.cy_px = static_cast<float>(height_px - 1) / 2.0F;
  }
  [[nodiscard]] const hal::CameraModel& model() const override { return model_; }
  [[nodiscard]] hal::CameraRead read(hal::Frame& out) override {
    next_ns_ = std::max(next_ns_ + period_ns_, clock_.now() - period_ns_);
    while (clock_.now() < next_ns_) {
      if (stopped_.load()) return {hal::CameraEvent::end, {}};
      clock_.sleep_until(std::min(next_ns_, clock_.now() + 5'000'000));
    }
    if (stopped_.load()) return {hal::CameraEvent::end, {}};
    out.stamp_ns = clock_.now();
    out.sequence = ++sequence_;
    out.has_colour = true;
    std::fill_n(out.depth.get(), model_.pixel_count(), static_cast<std::uint16_t>(sequence_));
    std::fill_n(out.rgb.get(), 3 * model_.pixel_count(), static_cast<std::uint8_t>(sequence_));
    return {hal::CameraEvent::frame, {}};
  }
  void stop() { stopped_.store(true); }

 private:
  hal::Clock& clock_;
  hal::CameraModel model_;
  hal::TimeNs period_ns_;
  hal::TimeNs next_ns_;
  std::uint64_t sequence_ = 0;
  std::atomic<bool> stopped_{false};
};

}  // namespace g3d::test
