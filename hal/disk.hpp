// SPDX-License-Identifier: Apache-2.0
// The system calls by which this program writes files. All writers go through here, so that a simulated run can have a
// disk that fails (sim/disk_faults.hpp) where a real one would.
#pragma once

#include <sys/types.h>

#include <cstddef>

namespace g3d::hal {

/// Every call returns what the system call of its name returns, with errno. Any thread.
class Disk {
 public:
  Disk() = default;
  virtual ~Disk() = default;
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;
  [[nodiscard]] virtual int open(const char* path, int flags, mode_t mode);
  [[nodiscard]] virtual ssize_t write(int fd, const void* data, std::size_t size_bytes);
  [[nodiscard]] virtual ssize_t pwrite(int fd, const void* data, std::size_t size_bytes, off_t offset);
  [[nodiscard]] virtual ssize_t pread(int fd, void* out, std::size_t size_bytes, off_t offset);
  [[nodiscard]] virtual int fsync(int fd);
  [[nodiscard]] virtual int ftruncate(int fd, off_t size_bytes);
  [[nodiscard]] virtual int rename(const char* from, const char* to);
};

/// The one that all writers use: the real one, unless another was named.
[[nodiscard]] Disk& disk();
/// Takes another one's place until this object goes. One at a time; begun before and ended after all threads that
/// write files.
class DiskInstead {
 public:
  explicit DiskInstead(Disk& other);
  ~DiskInstead();
  DiskInstead(const DiskInstead&) = delete;
  DiskInstead& operator=(const DiskInstead&) = delete;
};

}  // namespace g3d::hal
