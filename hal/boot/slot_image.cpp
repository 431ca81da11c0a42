// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/slot_image.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <utility>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kSlotRead_bytes = 1 << 20;

/// Returns 0, errno, or -1 where the file ends before.
int read_all_of_slot(int fd, std::uint64_t offset, std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = disk().pread(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    if (n == 0) return -1;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return 0;
}

Error read_error(const std::string& path, int failed) {
  if (failed > 0) return system_error(path, "cannot be read", failed);
  return {Reason::truncated, fmt::format("{}: is shorter than the image that it should hold; update it again", path)};
}

}  // namespace

Result<SlotImage> SlotImage::open_for_writing(const std::string& path) {
  const int fd = disk().open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
  if (fd < 0) return system_error(path, "cannot open", errno);
  struct stat status {};
  const bool is_known = ::fstat(fd, &status) == 0 && (S_ISREG(status.st_mode) || S_ISBLK(status.st_mode));
  if (!is_known) {
    ::close(fd);
    return Error{Reason::unsupported, fmt::format("{}: is neither a file nor a partition; give one of them", path)};
  }
  return SlotImage(path, fd, S_ISBLK(status.st_mode));
}

SlotImage::SlotImage(SlotImage&& other) noexcept
    : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)), is_device_(other.is_device_) {}

SlotImage::~SlotImage() {
  if (fd_ >= 0) ::close(fd_);
}

Result<void> SlotImage::make_room(std::uint64_t size_bytes) {
  const auto size = static_cast<off_t>(size_bytes);
  if (is_device_) {
    const off_t has = ::lseek(fd_, 0, SEEK_END);
    if (has < 0) return system_error(path_, "cannot be measured", errno);
    if (has >= size) return {};
    return Error{Reason::too_large,
                 fmt::format("{}: has {} bytes, the image {}; make a smaller one", path_, has, size)};
  }
  if (disk().ftruncate(fd_, size) != 0) return system_error(path_, "cannot get its size", errno);
  if (size == 0) return {};
  const int failed = ::posix_fallocate(fd_, 0, size);
  if (failed != 0) return system_error(path_, fmt::format("no room for {} bytes", size), failed);
  return {};
}

Result<void> SlotImage::read(std::uint64_t offset, std::span<std::uint8_t> bytes) const {
  if (const int failed = read_all_of_slot(fd_, offset, bytes); failed != 0) return read_error(path_, failed);
  return {};
}

Result<void> SlotImage::write(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = disk().pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return system_error(path_, "cannot be written", n < 0 ? errno : EIO);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return {};
}

Result<void> SlotImage::sync() {
  if (disk().fsync(fd_) != 0) return system_error(path_, "cannot be written", errno);
  (void)::posix_fadvise(fd_, 0, 0, POSIX_FADV_DONTNEED);
  return {};
}

Result<void> check_slot_image(const std::string& path, const SlotImageId& image, const std::function<void()>& between) {
  const int fd = disk().open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK, 0);
  if (fd < 0) return system_error(path, "cannot open", errno);
  const auto buffer = std::make_unique<std::uint8_t[]>(kSlotRead_bytes);
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, image.digest.size());
  int failed = 0;
  // Without a size, one byte tells whether something is there.
  const std::uint64_t wanted = std::max<std::uint64_t>(image.size_bytes, 1);
  for (std::uint64_t at = 0; at < wanted && failed == 0;) {
    const std::span part(buffer.get(), static_cast<std::size_t>(std::min<std::uint64_t>(kSlotRead_bytes, wanted - at)));
    failed = read_all_of_slot(fd, at, part);
    crypto_generichash_update(&state, part.data(), part.size());
    at += part.size();
    if (between) between();
  }
  ::close(fd);
  if (failed != 0) return read_error(path, failed);
  ImageDigest digest;
  crypto_generichash_final(&state, digest.data(), digest.size());
  if (image.size_bytes == 0 || digest == image.digest) return {};
  return Error{Reason::bad_checksum, fmt::format("{}: is not what was written there; update it again", path)};
}

}  // namespace g3d::hal
