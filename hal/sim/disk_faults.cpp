// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/disk_faults.hpp"

#include <fcntl.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <thread>
#include <utility>
#include <vector>

namespace g3d::hal {
namespace {

constexpr auto kLook = std::chrono::milliseconds(5);
constexpr auto kSlowWrite = std::chrono::milliseconds(200);
constexpr auto kLateSync = std::chrono::milliseconds(2000);
constexpr TimeNs kFullEvery_ns = 1'000'000'000;

int fail(int error) {
  errno = error;
  return -1;
}

std::vector<std::uint8_t> with_a_wrong_bit(const void* data, std::size_t size_bytes) {
  std::vector<std::uint8_t> bytes(size_bytes);
  if (size_bytes == 0) return bytes;
  std::memcpy(bytes.data(), data, size_bytes);
  bytes[size_bytes / 2] ^= 0x10;
  return bytes;
}

}  // namespace

DiskFaults::DiskFaults(FaultPlan plan, std::function<TimeNs()> now_ns)
    : plan_(std::move(plan)), now_ns_(std::move(now_ns)) {}

FaultKind DiskFaults::kind() const { return fault_at(plan_, FaultPart::disk, now_ns_()).kind; }

bool DiskFaults::writes_garbage() const { return kind() == FaultKind::garbage; }

int DiskFaults::trouble() {
  while (kind() == FaultKind::stuck) std::this_thread::sleep_for(kLook);
  const FaultNow now = fault_at(plan_, FaultPart::disk, now_ns_());
  switch (now.kind) {
    case FaultKind::off:
      return EIO;
    case FaultKind::wrong:
      return EROFS;
    case FaultKind::intermittent:
      return now.since_ns % kFullEvery_ns < kFullEvery_ns / 2 ? ENOSPC : 0;
    default:
      return 0;
  }
}

int DiskFaults::open(const char* path, int flags, mode_t mode) {
  const int error = trouble();
  const bool reads = (flags & O_ACCMODE) == O_RDONLY;
  if (error == EIO || (error == EROFS && !reads)) return fail(error);
  return Disk::open(path, flags, mode);
}

ssize_t DiskFaults::write(int fd, const void* data, std::size_t size_bytes) {
  if (const int error = trouble(); error != 0) return fail(error);
  if (kind() == FaultKind::slow) std::this_thread::sleep_for(kSlowWrite);
  if (!writes_garbage()) return Disk::write(fd, data, size_bytes);
  return Disk::write(fd, with_a_wrong_bit(data, size_bytes).data(), size_bytes);
}

ssize_t DiskFaults::pwrite(int fd, const void* data, std::size_t size_bytes, off_t offset) {
  if (const int error = trouble(); error != 0) return fail(error);
  if (kind() == FaultKind::slow) std::this_thread::sleep_for(kSlowWrite);
  if (!writes_garbage()) return Disk::pwrite(fd, data, size_bytes, offset);
  return Disk::pwrite(fd, with_a_wrong_bit(data, size_bytes).data(), size_bytes, offset);
}

ssize_t DiskFaults::pread(int fd, void* out, std::size_t size_bytes, off_t offset) {
  if (trouble() == EIO) return fail(EIO);
  return Disk::pread(fd, out, size_bytes, offset);
}

int DiskFaults::fsync(int fd) {
  if (const int error = trouble(); error != 0) return fail(error);
  if (kind() == FaultKind::delayed) std::this_thread::sleep_for(kLateSync);
  return Disk::fsync(fd);
}

int DiskFaults::ftruncate(int fd, off_t size_bytes) {
  const int error = trouble();
  if (error == EIO || error == EROFS) return fail(error);  // a full disk can still be emptied
  return Disk::ftruncate(fd, size_bytes);
}

int DiskFaults::rename(const char* from, const char* to) {
  if (const int error = trouble(); error != 0) return fail(error);
  return Disk::rename(from, to);
}

}  // namespace g3d::hal
