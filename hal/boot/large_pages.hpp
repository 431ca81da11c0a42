// SPDX-License-Identifier: Apache-2.0
// Large pages for who asks for them. Kernels switch them off by themselves on machines with less than 512 MB.
#pragma once

#include <string>

namespace g3d::hal::boot {

/// "madvise" unless it is that or "always" already. False: this kernel has none, or does not let itself be told.
bool allow_large_pages(const std::string& switch_file = "/sys/kernel/mm/transparent_hugepage/enabled");

}  // namespace g3d::hal::boot
