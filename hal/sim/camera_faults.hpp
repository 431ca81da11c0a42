// SPDX-License-Identifier: Apache-2.0
// What can go wrong with a camera, applied to frames that a good one took. One thread; nothing is allocated after
// construction.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/seeded_random.hpp"

namespace g3d::hal {

enum class CameraFault : std::uint8_t {
  none,
  off,           ///< no frame comes
  stuck,         ///< new stamps, the image of the first frame for ever
  garbage,       ///< depth of chance
  wrong,         ///< everything reads 1.5 times as far as it is
  slow,          ///< every tenth frame comes
  delayed,       ///< frames come kDelay_frames later, with the stamps they were taken at
  intermittent,  ///< ten frames come, ten do not
};

class CameraFaults {
 public:
  static constexpr std::size_t kDelay_frames = 10;

  CameraFaults(const CameraModel& camera, std::uint64_t seed);

  void set(CameraFault fault);
  /// Spoils `frame` in place; false if the host gets none this time.
  [[nodiscard]] bool apply(Frame& frame);

 private:
  CameraModel camera_;
  SeededRandom random_;
  CameraFault fault_ = CameraFault::none;
  std::uint64_t since_ = 0;  ///< frames since the fault began
  std::vector<Frame> kept_;  ///< ring of those that are late; the first one also keeps what is stuck
};

}  // namespace g3d::hal
