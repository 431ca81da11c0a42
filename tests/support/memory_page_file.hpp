// SPDX-License-Identifier: Apache-2.0
// A page file in memory that can be full, slow, or lose bytes.
#pragma once

#include <atomic>
#include <chrono>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

#include "mapper/page_file.hpp"

namespace g3d::tests {

class MemoryPageFile final : public mapper::PageFile {
 public:
  hal::Result<void> write(std::uint64_t offset, std::span<const std::uint8_t> in) override {
    pause();
    const std::lock_guard lock(mutex_);
    if (offset + in.size() > full_at_bytes) return hal::Error{hal::Reason::disk_full, "page file: the disk is full"};
    if (bytes_.size() < offset + in.size()) bytes_.resize(offset + in.size());
    std::memcpy(bytes_.data() + offset, in.data(), in.size());
    if (spoil_writes && !in.empty()) bytes_[offset + in.size() / 2] ^= 0x10U;
    return {};
  }
  hal::Result<void> read(std::uint64_t offset, std::span<std::uint8_t> out) override {
    pause();
    const std::lock_guard lock(mutex_);
    if (offset + out.size() > bytes_.size()) return hal::Error{hal::Reason::truncated, "page file: ends too early"};
    std::memcpy(out.data(), bytes_.data() + offset, out.size());
    return {};
  }
  hal::Result<void> truncate(std::uint64_t bytes) override {
    const std::lock_guard lock(mutex_);
    bytes_.resize(bytes);
    return {};
  }

  /// Any thread: one bit of what is stored turns over.
  void spoil(std::size_t offset) {
    const std::lock_guard lock(mutex_);
    if (offset < bytes_.size()) bytes_[offset] ^= 0x01U;
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

  std::uint64_t full_at_bytes = ~std::uint64_t{0};
  bool spoil_writes = false;
  int delay_us = 0;

 private:
  void pause() const {
    if (delay_us > 0) std::this_thread::sleep_for(std::chrono::microseconds(delay_us));
  }
  std::mutex mutex_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace g3d::tests
