// SPDX-License-Identifier: Apache-2.0
// Keeps the program's code and data in memory, so that the thread that drives the base never waits for a disk to bring
// a page of them back.
#pragma once

#include "hal/result.hpp"

namespace g3d::hal {

/// What is mapped at this moment, page by page as it is first used. Called before the big arrays of the map are made:
/// those are given back to the system by MADV_DONTNEED, which the kernel refuses for locked memory, and they are asked
/// for in huge pages anyway. Errors: no_permission (with the limit that is in the way), unsupported, io_error.
[[nodiscard]] Result<void> lock_program_memory();

}  // namespace g3d::hal
