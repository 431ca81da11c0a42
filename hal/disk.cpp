// SPDX-License-Identifier: Apache-2.0
#include "hal/disk.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>

namespace g3d::hal {
namespace {

std::atomic<Disk*> instead{nullptr};

}  // namespace

int Disk::open(const char* path, int flags, mode_t mode) { return ::open(path, flags, mode); }
ssize_t Disk::write(int fd, const void* data, std::size_t size_bytes) { return ::write(fd, data, size_bytes); }
ssize_t Disk::pwrite(int fd, const void* data, std::size_t size_bytes, off_t offset) {
  return ::pwrite(fd, data, size_bytes, offset);
}
ssize_t Disk::pread(int fd, void* out, std::size_t size_bytes, off_t offset) {
  return ::pread(fd, out, size_bytes, offset);
}
int Disk::fsync(int fd) { return ::fsync(fd); }
int Disk::ftruncate(int fd, off_t size_bytes) { return ::ftruncate(fd, size_bytes); }
int Disk::rename(const char* from, const char* to) { return ::rename(from, to); }

Disk& disk() {
  static Disk real;
  Disk* const other = instead.load(std::memory_order_acquire);
  return other != nullptr ? *other : real;
}

DiskInstead::DiskInstead(Disk& other) { instead.store(&other, std::memory_order_release); }
DiskInstead::~DiskInstead() { instead.store(nullptr, std::memory_order_release); }

}  // namespace g3d::hal
