// SPDX-License-Identifier: Apache-2.0
// Camera paths: any bytes give a path whose poses are valid at every time, or an error with a text.
#include <cstdlib>
#include <string_view>

#include "hal/sim/camera_path.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  const auto path = parse_camera_path({reinterpret_cast<const char*>(data), size_bytes}, "fuzz.path");
  if (!path) {
    if (path.error().text.find("fuzz.path") != 0) std::abort();
    return 0;
  }
  const TimeNs begin_ns = path.value().begin_ns();
  const TimeNs end_ns = path.value().end_ns();
  if (end_ns < begin_ns) std::abort();
  for (int i = -1; i <= 17; ++i) {
    if (!is_valid(path.value().pose_at(begin_ns + (end_ns - begin_ns) / 16 * i))) std::abort();
  }
  return 0;
}
