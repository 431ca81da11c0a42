// SPDX-License-Identifier: Apache-2.0
// How far a run has come: one line that is drawn over itself on a terminal, a plain line now and then elsewhere.
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

#include "hal/messages.hpp"
#include "mapper/pipeline.hpp"

namespace g3d::mapper {

enum class ProgressStyle : std::uint8_t {
  quiet,
  plain,     ///< for logs: a line every five seconds
  terminal,  ///< a bar
};

/// "[######----] 120/200 frames  61.3/s  2 dropped"; without a known total, no bar.
[[nodiscard]] std::string progress_text(const Progress& progress, std::optional<std::uint64_t> total, double rate_hz,
                                        ProgressStyle style);

/// One thread.
class ProgressBar {
 public:
  ProgressBar(std::FILE* out, ProgressStyle style, std::optional<std::uint64_t> total);
  void update(const Progress& progress, hal::TimeNs now_ns);
  /// The last line; leaves the cursor on a new one.
  void finish(const Progress& progress, hal::TimeNs now_ns);

 private:
  void print(const Progress& progress, double rate_hz);

  std::FILE* out_;
  ProgressStyle style_;
  std::optional<std::uint64_t> total_;
  std::optional<hal::TimeNs> start_ns_;
  hal::TimeNs last_print_ns_ = 0;
  std::uint64_t frames_at_last_print_ = 0;
  std::size_t last_length_ = 0;
};

}  // namespace g3d::mapper
