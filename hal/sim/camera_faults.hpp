// SPDX-License-Identifier: Apache-2.0
// What can go wrong with a camera, applied to frames that a good one took:
//
//   off           no frame comes
//   stuck         new stamps, the image of the first frame for ever
//   garbage       depth of chance
//   wrong         everything reads 1.5 times as far as it is
//   slow          every tenth frame comes
//   delayed       frames come kDelay_frames later, with the stamps they were taken at
//   intermittent  ten frames do not come, ten do
//
// One thread; nothing is allocated after construction.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/fault_plan.hpp"
#include "hal/sim/seeded_random.hpp"

namespace g3d::hal {

class CameraFaults {
 public:
  static constexpr std::size_t kDelay_frames = 10;

  CameraFaults(const CameraModel& camera, std::uint64_t seed);

  /// Begins anew only where it is another one.
  void set(FaultKind fault);
  /// Spoils `frame` in place; false if the host gets none this time.
  [[nodiscard]] bool apply(Frame& frame);

 private:
  CameraModel camera_;
  SeededRandom random_;
  FaultKind fault_ = FaultKind::none;
  std::uint64_t since_ = 0;  ///< frames since the fault began
  std::vector<Frame> kept_;  ///< ring of those that are late; the first one also keeps what is stuck
};

}  // namespace g3d::hal
