// SPDX-License-Identifier: Apache-2.0
// What can go wrong with a disk, done to the calls of a good one:
//
//   off           pulled out: every call fails (EIO)
//   stuck         no call returns until the fault is over
//   garbage       one bit of each write is another one
//   wrong         may only be read from now on (EROFS), as a kernel does after errors
//   slow          every write takes 0.2 s
//   delayed       what is written is kept back: it takes 2 s until the disk says that it is safe
//   intermittent  full (ENOSPC) for half of each second
//
// What was opened before a fault and is closed in it was, of course, never written.
#pragma once

#include <functional>

#include "hal/disk.hpp"
#include "hal/sim/fault_plan.hpp"

namespace g3d::hal {

class DiskFaults final : public Disk {
 public:
  /// `now_ns` since the simulation began, by any thread.
  DiskFaults(FaultPlan plan, std::function<TimeNs()> now_ns);
  [[nodiscard]] int open(const char* path, int flags, mode_t mode) override;
  [[nodiscard]] ssize_t write(int fd, const void* data, std::size_t size_bytes) override;
  [[nodiscard]] ssize_t pwrite(int fd, const void* data, std::size_t size_bytes, off_t offset) override;
  [[nodiscard]] ssize_t pread(int fd, void* out, std::size_t size_bytes, off_t offset) override;
  [[nodiscard]] int fsync(int fd) override;
  [[nodiscard]] int ftruncate(int fd, off_t size_bytes) override;
  [[nodiscard]] int rename(const char* from, const char* to) override;

 private:
  /// Waits as long as the fault wants; then 0, or the errno with which a call that changes something fails.
  [[nodiscard]] int trouble();
  [[nodiscard]] bool writes_garbage() const;
  [[nodiscard]] FaultKind kind() const;

  const FaultPlan plan_;
  const std::function<TimeNs()> now_ns_;
};

}  // namespace g3d::hal
