// SPDX-License-Identifier: Apache-2.0
#include "mapper/progress_bar.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace g3d::mapper {
namespace {

constexpr int kBarWidth = 30;
constexpr hal::TimeNs kPlainPeriod_ns = 5'000'000'000;

}  // namespace

std::string progress_text(const Progress& progress, std::optional<std::uint64_t> total, double rate_hz,
                          ProgressStyle style) {
  std::string text;
  if (style == ProgressStyle::terminal && total && *total > 0) {
    const double done = std::min(1.0, static_cast<double>(progress.delivered) / static_cast<double>(*total));
    const auto filled = static_cast<std::size_t>(done * kBarWidth);
    text = fmt::format("[{}{}] ", std::string(filled, '#'), std::string(kBarWidth - filled, '-'));
  }
  text +=
      total ? fmt::format("{}/{} frames", progress.delivered, *total) : fmt::format("{} frames", progress.delivered);
  text += fmt::format("  {:.1f}/s", rate_hz);
  if (progress.dropped > 0) text += fmt::format("  {} dropped", progress.dropped);
  return text;
}

ProgressBar::ProgressBar(std::FILE* out, ProgressStyle style, std::optional<std::uint64_t> total)
    : out_(out), style_(style), total_(total) {}

void ProgressBar::update(const Progress& progress, hal::TimeNs now_ns) {
  if (style_ == ProgressStyle::quiet) return;
  if (!start_ns_) {
    start_ns_ = last_print_ns_ = now_ns;
    if (style_ == ProgressStyle::plain) return;
  }
  const hal::TimeNs since_ns = now_ns - last_print_ns_;
  if (style_ == ProgressStyle::plain && since_ns < kPlainPeriod_ns) return;
  const double frames = static_cast<double>(progress.delivered - frames_at_last_print_);
  print(progress, since_ns > 0 ? frames * 1e9 / static_cast<double>(since_ns) : 0.0);
  if (since_ns >= 1'000'000'000) {  // the rate shown is that of the last second or so
    last_print_ns_ = now_ns;
    frames_at_last_print_ = progress.delivered;
  }
}

void ProgressBar::finish(const Progress& progress, hal::TimeNs now_ns) {
  if (style_ == ProgressStyle::quiet) return;
  const double run_s = start_ns_ ? static_cast<double>(now_ns - *start_ns_) / 1e9 : 0.0;
  print(progress, run_s > 0.0 ? static_cast<double>(progress.delivered) / run_s : 0.0);
  if (style_ == ProgressStyle::terminal) std::fputc('\n', out_);
  std::fflush(out_);
}

void ProgressBar::print(const Progress& progress, double rate_hz) {
  std::string text = progress_text(progress, total_, rate_hz, style_);
  if (style_ == ProgressStyle::terminal) {
    const std::size_t length = text.size();
    if (length < last_length_) text.append(last_length_ - length, ' ');
    last_length_ = length;
    std::fputc('\r', out_);
  } else {
    text += '\n';
  }
  std::fputs(text.c_str(), out_);
  std::fflush(out_);
}

}  // namespace g3d::mapper
