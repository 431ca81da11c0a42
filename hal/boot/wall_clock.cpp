// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/wall_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "hal/image/file_bytes.hpp"

namespace g3d::hal::boot {
namespace {
constexpr std::int64_t kLatest_s = 4'102'444'800;  // 2100-01-01
}

std::int64_t believable_time_s(std::int64_t clock_s, std::int64_t saved_s, std::int64_t built_s) {
  const std::int64_t saved = saved_s >= 0 && saved_s < kLatest_s ? saved_s : 0;
  return std::max({clock_s, saved, built_s});
}

std::int64_t read_saved_time_s(const std::string& path) {
  const auto text = read_text_file(path, 64);
  if (!text) return 0;
  const char* const begin = text.value().data();
  const char* const end = begin + text.value().size();
  std::int64_t time_s = 0;
  const auto [next, code] = std::from_chars(begin, end, time_s);
  const bool is_whole = code == std::errc{} && next != begin && (next == end || *next == '\n');
  return is_whole && time_s > 0 && time_s < kLatest_s ? time_s : 0;
}

Result<void> save_time(const std::string& path, std::int64_t time_s) {
  return write_file_atomic(path, fmt::format("{}\n", time_s));
}

}  // namespace g3d::hal::boot
