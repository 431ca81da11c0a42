// SPDX-License-Identifier: Apache-2.0
// What is read as a calibration is written and read again without a difference.
#include <cstdlib>
#include <string_view>

#include "hal/kinect/calibration.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal::kinect;
  const auto read = parse_calibration({reinterpret_cast<const char*>(data), size_bytes}, "fuzz.toml");
  if (!read) return 0;
  const auto again = parse_calibration(calibration_text(read.value()), "again.toml");
  if (!again || !(again.value() == read.value())) std::abort();
  return 0;
}
