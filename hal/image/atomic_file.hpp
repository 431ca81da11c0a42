// SPDX-License-Identifier: Apache-2.0
// A file that is either the old one or the whole new one, whenever the process is killed or the disk is full: written
// as `PATH.part`, then fsync, read back and compared, renamed over PATH, fsync of the folder. A left-over part of a
// killed process is reused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "hal/result.hpp"

namespace g3d::hal {

/// The Error for a failed system call on `path`: reason and remedy follow from `errno_value`.
[[nodiscard]] Error system_error(const std::string& path, std::string_view what, int errno_value);

/// One thread at a time. Destroyed before commit(): the old file stays, the part is removed.
class AtomicFile {
 public:
  /// Refuses if another process or object is writing the same file right now (Reason::no_permission).
  static Result<AtomicFile> create(const std::string& path);
  /// For secrets: mode 0600 from the first byte on, and no copy left in memory. Refuses a part that is somebody else's.
  static Result<AtomicFile> create_private(const std::string& path);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

  /// Buffered. After a failure the part is gone, and every further call repeats the error.
  Result<void> write(std::span<const std::uint8_t> bytes);
  Result<void> write(std::string_view text);
  /// Makes the new file the real one. Nothing may be written afterwards.
  Result<void> commit();
  void abandon();
  [[nodiscard]] std::uint64_t bytes_written() const { return bytes_written_; }

 private:
  AtomicFile(std::string path, int fd, bool is_private);
  static Result<AtomicFile> create(const std::string& path, bool is_private);
  Result<void> flush();
  Result<void> check_what_came_back();
  Error fail(std::string_view what, int errno_value);

  std::string path_;
  int fd_ = -1;
  bool is_private_ = false;
  std::unique_ptr<std::uint8_t[]> buffer_;
  std::size_t buffered_bytes_ = 0;
  std::uint32_t checksum_ = 0;  ///< CRC-32 of all that was to be written
  std::uint64_t bytes_written_ = 0;
  Error error_;  // what write and commit answer while fd_ is closed
};

}  // namespace g3d::hal
