// SPDX-License-Identifier: Apache-2.0
// Between times in nanoseconds and spans in seconds.
#pragma once

#include "hal/messages.hpp"

namespace g3d::nav {

[[nodiscard]] inline hal::TimeNs after(hal::TimeNs from, double span_s) {
  return from + static_cast<hal::TimeNs>(span_s * 1e9);
}
[[nodiscard]] inline double seconds_between(hal::TimeNs from, hal::TimeNs to) {
  return static_cast<double>(to - from) * 1e-9;
}

}  // namespace g3d::nav
