// SPDX-License-Identifier: Apache-2.0
// What a Kinect's foot may say stays within what one can feel and turn.
#include <cmath>
#include <cstdlib>

#include "hal/kinect/tilt_unit.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  const auto state = g3d::hal::kinect::parse_tilt_state({data, size_bytes});
  if (!state) return 0;
  for (const double g : state.value().acceleration_g) {
    if (!(std::abs(g) < 2.6)) std::abort();
  }
  if (!(std::abs(state.value().tilt_deg) <= 45.0)) std::abort();
  return 0;
}
