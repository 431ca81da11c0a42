// SPDX-License-Identifier: Apache-2.0
// The bytes of one slot: a file on the data partition, or a partition of its own. Written at any offset, read back from
// the disk itself, digested. Used by one thread; blocks on the disk.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "hal/boot/slots.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

class SlotImage {
 public:
  /// A file that is not there yet is made. Errors: not_found (its folder), no_permission, unsupported (neither file nor
  /// block device), io_error.
  [[nodiscard]] static Result<SlotImage> open_for_writing(const std::string& path);
  SlotImage(SlotImage&& other) noexcept;
  SlotImage& operator=(SlotImage&&) = delete;
  ~SlotImage();

  /// A file gets exactly that size, and the disk's promise of room for it; a device must have it. Errors: disk_full,
  /// too_large, io_error.
  [[nodiscard]] Result<void> make_room(std::uint64_t size_bytes);
  /// The whole span or an error: truncated, io_error.
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::uint8_t> bytes) const;
  [[nodiscard]] Result<void> write(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  /// What was written is safe, and the next read is answered by the disk, as far as anybody can ask it to.
  [[nodiscard]] Result<void> sync();

 private:
  SlotImage(std::string path, int fd, bool is_device) : path_(std::move(path)), fd_(fd), is_device_(is_device) {}
  std::string path_;
  int fd_;
  bool is_device_;
};

/// Whether the slot holds that image; size 0 asks only whether something is there. `between`, if any, is called every
/// MiB or so: to feed a watchdog. Errors: not_found, truncated, bad_checksum, io_error.
[[nodiscard]] Result<void> check_slot_image(const std::string& path, const SlotImageId& image,
                                            const std::function<void()>& between = {});

}  // namespace g3d::hal
