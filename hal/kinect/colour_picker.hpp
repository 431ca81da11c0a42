// SPDX-License-Identifier: Apache-2.0
// Which colour image belongs to a depth image: the nearest in time by the sensor's own clock, of those that have come.
// A camera thread that is behind finds newer ones as well; those are kept for the depth images that follow.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/kinect/image_intake.hpp"

namespace g3d::hal::kinect {

/// The camera thread's. `intake` outlives it.
class ColourPicker {
 public:
  explicit ColourPicker(ImageIntake& intake) : intake_(intake) {}

  /// For another sensor, or the same opened anew. Gives back what it holds.
  void begin(double tick_ns, int tick_bits) {
    for (auto* held : {&best_, &ahead_}) {
      if (*held) intake_.release(ImageKind::colour, **held);
      held->reset();
    }
    tick_ns_ = tick_ns;
    tick_bits_ = tick_bits;
  }

  /// R G B of the image nearest to `depth_ticks`, valid until the next call; nullptr if none is within `within_ns`.
  [[nodiscard]] const std::uint8_t* pick(std::uint64_t depth_ticks, TimeNs within_ns) {
    for (;;) {
      ImageIntake::Taken next;
      if (!ahead_ && intake_.try_take(ImageKind::colour, next)) ahead_ = next;
      if (!ahead_) break;
      if (best_ && distance_ns(*best_, depth_ticks) < distance_ns(*ahead_, depth_ticks)) break;
      if (best_) intake_.release(ImageKind::colour, *best_);
      best_ = ahead_;
      ahead_.reset();
    }
    const bool is_near = best_ && distance_ns(*best_, depth_ticks) <= static_cast<double>(within_ns);
    return is_near ? intake_.rgb(*best_) : nullptr;
  }

 private:
  [[nodiscard]] double distance_ns(const ImageIntake::Taken& colour, std::uint64_t depth_ticks) const {
    const std::uint64_t mask = tick_bits_ >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << tick_bits_) - 1;
    const std::uint64_t ahead = (colour.device_ticks - depth_ticks) & mask,
                        behind = (depth_ticks - colour.device_ticks) & mask;
    return static_cast<double>(ahead < behind ? ahead : behind) * tick_ns_;
  }

  ImageIntake& intake_;
  double tick_ns_ = 1000.0;
  int tick_bits_ = 64;
  std::optional<ImageIntake::Taken> best_;
  std::optional<ImageIntake::Taken> ahead_;  // newer, and not nearer
};

}  // namespace g3d::hal::kinect
