// SPDX-License-Identifier: Apache-2.0
// What came over the base's line, as it came, into `kobuki.bin`: records of i64 t_ns, u16 n, n bytes, little-endian.
// The thread at the line only fills a ring; a thread of its own writes, so that a slow or full disk costs records,
// which are counted, and never a tick; once it takes records again they follow whole.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "hal/messages.hpp"
#include "hal/parking.hpp"
#include "hal/record/append_file.hpp"
#include "hal/result.hpp"
#include "hal/ring.hpp"

namespace g3d::hal::kobuki {

class LineRecorder {
 public:
  /// Starts an empty file and the thread. Errors: those of AppendFile::create().
  [[nodiscard]] static Result<std::unique_ptr<LineRecorder>> create(const std::string& path);
  ~LineRecorder();
  LineRecorder(const LineRecorder&) = delete;
  LineRecorder& operator=(const LineRecorder&) = delete;

  /// The line's thread. Never waits.
  void put(std::span<const std::uint8_t> bytes, TimeNs t_ns);
  /// Writes what is left and closes; the line's thread has ended. Errors: disk_full, io_error (the first that
  /// occurred).
  [[nodiscard]] Result<void> finish();
  /// Any thread. Bytes that are not in the file, because the disk was behind or refused them.
  [[nodiscard]] std::uint64_t lost_bytes() const { return lost_bytes_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kChunk_bytes = 246;
  static constexpr std::size_t kChunks = 1024;  // some ten seconds
  struct Chunk {
    TimeNs t_ns = 0;
    std::uint16_t size = 0;
    std::array<std::uint8_t, kChunk_bytes> bytes{};
  };

  explicit LineRecorder(AppendFile file);
  void write_all();
  void write_one(const Chunk& chunk);

  // The writer's; after it was joined, of whoever ends
  AppendFile file_;
  int first_errno_ = 0;
  Ring<Chunk> ring_{kChunks};
  Parking writer_waits_;
  std::atomic<std::uint64_t> lost_bytes_{0};
  std::thread writer_;
};

}  // namespace g3d::hal::kobuki
