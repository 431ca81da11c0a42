// SPDX-License-Identifier: Apache-2.0
// Lines of text from a thread that may not wait into a file: `can.log`, `gpio.log`. That thread only fills a ring; one
// of the recorder's own writes, so that a slow or full disk costs lines, which are counted, and never a tick. A line is
// in the file whole or not at all; what was written survives the death of the process.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "hal/parking.hpp"
#include "hal/result.hpp"
#include "hal/ring.hpp"

namespace g3d::hal {

class TextRecorder {
 public:
  static constexpr std::size_t kMaxLine_bytes = 95;

  /// Starts an empty file and the thread. Errors: not_found, no_permission, disk_full, io_error.
  [[nodiscard]] static Result<std::unique_ptr<TextRecorder>> create(const std::string& path);
  ~TextRecorder();
  TextRecorder(const TextRecorder&) = delete;
  TextRecorder& operator=(const TextRecorder&) = delete;

  /// One thread. `line` with its newline; a longer one than kMaxLine_bytes is lost. Never waits.
  void put(std::string_view line);
  /// Writes what is left and closes; nobody puts any more. Errors: disk_full, io_error (the first that occurred).
  [[nodiscard]] Result<void> finish();
  /// Any thread. Lines that are not in the file.
  [[nodiscard]] std::uint64_t lost_lines() const { return lost_lines_.load(std::memory_order_relaxed); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  static constexpr std::size_t kLines = 8192;  // a second of a bus of 1 Mbit/s that is full of short frames, or nearly
  struct Line {
    std::uint8_t size = 0;
    std::array<char, kMaxLine_bytes> text{};
  };

  TextRecorder(std::string path, int fd);
  void write_all();
  void write_one(const Line& line);
  [[nodiscard]] bool cut_to_whole_lines();

  const std::string path_;
  int fd_;
  Ring<Line> ring_{kLines};
  Parking writer_waits_;
  std::atomic<std::uint64_t> lost_lines_{0};
  // The writer's, read after it was joined
  int first_errno_ = 0;
  std::int64_t whole_bytes_ = 0;
  bool ends_in_half_a_line_ = false;
  std::thread writer_;
};

}  // namespace g3d::hal
