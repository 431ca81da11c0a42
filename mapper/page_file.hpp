// SPDX-License-Identifier: Apache-2.0
// The bytes under the page store. The real one is a file without a name in the output folder: it vanishes with the
// process, however that ends. Tests put a disk that is full or forgets in its place.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/result.hpp"

namespace g3d::mapper {

class PageFile {
 public:
  virtual ~PageFile() = default;
  virtual hal::Result<void> write(std::uint64_t offset, std::span<const std::uint8_t> bytes) = 0;
  /// Fewer bytes than asked for are an error (truncated).
  virtual hal::Result<void> read(std::uint64_t offset, std::span<std::uint8_t> out) = 0;
  virtual hal::Result<void> truncate(std::uint64_t bytes) = 0;
};

/// Errors: those of the file system; texts name the folder and what to do.
[[nodiscard]] hal::Result<std::unique_ptr<PageFile>> create_page_file(const std::string& folder);

}  // namespace g3d::mapper
