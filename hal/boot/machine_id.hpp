// SPDX-License-Identifier: Apache-2.0
// What a machine is called that no operating system has given a name: 128 random bits, made at its first start, kept on
// its data partition, and shown where programs look for it (machine-id(5)). Cold paths only.
#pragma once

#include <string>

#include "hal/result.hpp"

namespace g3d::hal::boot {

/// `kept`: the file that survives; made if it is not there, or is no id. `shown`: becomes a link to it; its folder is
/// made. Errors: those of the file system; `shown` may then be missing.
[[nodiscard]] Result<void> keep_machine_id(const std::string& kept, const std::string& shown);

}  // namespace g3d::hal::boot
