// SPDX-License-Identifier: Apache-2.0
// Time of day on a machine whose clock may have lost its battery: what the hardware says, but never earlier than what a
// file on the data partition says that it has been already.
#pragma once

#include <cstdint>
#include <string>

#include "hal/result.hpp"

namespace g3d::hal::boot {

/// Seconds since 1970. `clock_s`: of the running system; `saved_s`: of the file, 0 without one; `built_s`: when this
/// program was built. Nothing that is later than 2100 is believed of a file.
[[nodiscard]] std::int64_t believable_time_s(std::int64_t clock_s, std::int64_t saved_s, std::int64_t built_s);

/// 0 if there is none, or nothing sensible in it.
[[nodiscard]] std::int64_t read_saved_time_s(const std::string& path);
/// Whole or not at all. Errors: those of AtomicFile.
[[nodiscard]] Result<void> save_time(const std::string& path, std::int64_t time_s);

}  // namespace g3d::hal::boot
