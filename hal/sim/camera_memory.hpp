// SPDX-License-Identifier: Apache-2.0
// From where a camera has looked, to answer one question about a contact: could the camera have measured this thing
// beforehand? It could if, in some earlier frame, a point of the thing above the place of contact lay inside the image
// at a depth of 0.8 to 3.5 m with nothing opaque before it. Black and glass things never can. What stands still is
// asked of all frames since the start (after 65536 of them, of every second one), what moves only of the last few
// seconds, at the places it had then, and not of the last 0.3 s, when it was too late. People and robots hide nothing
// here: that errs on the strict side.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/floor_contact.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

class CameraMemory {
 public:
  static constexpr std::size_t kFrames = 1 << 16;
  static constexpr std::size_t kRecentFrames = 64;
  static constexpr TimeNs kTooLate_ns = 300'000'000;
  static constexpr double kNear_m = 0.8;
  static constexpr double kFar_m = 3.5;

  /// `world` must outlive this.
  CameraMemory(const World& world, const CameraModel& camera);

  /// A frame was taken. Allocates nothing.
  void add(TimeNs time_ns, const Pose& T_world_camera, MoverPlaces places_m);
  /// `slice`: what of the thing a robot can touch.
  [[nodiscard]] bool could_measure(const FloorContact::Thing& thing, const HeightSlice& slice, TimeNs now_ns) const;
  [[nodiscard]] std::size_t frames() const { return frames_.size(); }

 private:
  struct View {
    std::array<double, 3> eye_m;
    std::array<float, 9> rotation;  ///< camera to world, row-major
  };
  [[nodiscard]] bool sees(const View& view, const std::array<double, 3>& point_m, double tolerance_m) const;

  const World& world_;
  CameraModel camera_;
  std::vector<View> frames_;
  std::size_t every_ = 1;  ///< which frames are kept
  std::size_t seen_ = 0;
  // Rings of the last frames, with the places of the movers in them.
  std::vector<View> recent_;
  std::vector<TimeNs> recent_ns_;
  std::vector<std::array<float, 2>> recent_places_m_;
};

}  // namespace g3d::hal
