// SPDX-License-Identifier: Apache-2.0
// Lines of text from a thread that may not wait into a file: `can.log`, `gpio.log`. That thread only fills a ring; one
// of the recorder's own writes, so that a slow or full disk costs lines, which are counted, and never a tick. A line is
// in the file whole or not at all.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "hal/parking.hpp"
#include "hal/record/append_file.hpp"
#include "hal/result.hpp"
#include "hal/ring.hpp"

namespace g3d::hal {

class TextRecorder {
 public:
  static constexpr std::size_t kMaxLine_bytes = 95;

  /// Starts an empty file and the thread. Errors: those of AppendFile::create().
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
  [[nodiscard]] const std::string& path() const { return file_.path(); }

 private:
  static constexpr std::size_t kLines = 8192;  // a second of a bus of 1 Mbit/s that is full of short frames, or nearly
  struct Line {
    std::uint8_t size = 0;
    std::array<char, kMaxLine_bytes> text{};
  };

  explicit TextRecorder(AppendFile file);
  void write_all();

  // The writer's; after it was joined, of whoever ends
  AppendFile file_;
  int first_errno_ = 0;
  Ring<Line> ring_{kLines};
  Parking writer_waits_;
  std::atomic<std::uint64_t> lost_lines_{0};
  std::thread writer_;
};

}  // namespace g3d::hal
