// SPDX-License-Identifier: Apache-2.0
// Whole files in and out of memory: reads are bounded by the caller, writes leave the old or the new file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/image/atomic_file.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// Reads a regular file of at most `max_bytes`. `bytes` is replaced and keeps its capacity, so that a caller who reads
/// many files allocates only for a larger one; on failure it is empty.
Result<void> read_file_into(const std::string& path, std::size_t max_bytes, std::vector<std::uint8_t>& bytes);
Result<std::vector<std::uint8_t>> read_file(const std::string& path, std::size_t max_bytes);
Result<std::string> read_text_file(const std::string& path, std::size_t max_bytes);

/// See AtomicFile.
Result<void> write_file_atomic(const std::string& path, std::span<const std::uint8_t> bytes);
Result<void> write_file_atomic(const std::string& path, std::string_view text);

}  // namespace g3d::hal
