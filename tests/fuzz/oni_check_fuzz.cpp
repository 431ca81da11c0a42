// SPDX-License-Identifier: Apache-2.0
// What is taken for a good .oni file has images of a size that we can hold.
#include <cstdlib>

#include "hal/kinect/oni_check.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  const auto checked = g3d::hal::kinect::check_oni({data, size_bytes}, "fuzz.oni");
  if (checked.ok() && (checked.value().depth.width_px < 16 || checked.value().depth.frames == 0)) std::abort();
  return 0;
}
