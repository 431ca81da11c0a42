// SPDX-License-Identifier: Apache-2.0
// What the kernel is told by way of a file under /sys or /proc/sys.
#pragma once

#include <string>
#include <string_view>

namespace g3d::hal::boot {

/// In one piece, as such files want it; none is made. False: there is no such file, or the kernel does not take it.
bool set_kernel(const std::string& file, std::string_view value);

}  // namespace g3d::hal::boot
