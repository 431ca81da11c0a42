// SPDX-License-Identifier: Apache-2.0
#include "mapper/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

namespace g3d::mapper {
namespace {

std::string dropped_text(const FrameCounts& frames) {
  std::string text;
  for (std::size_t i = 0; i < hal::kDropReasonCount; ++i) {
    if (frames.dropped[i] == 0) continue;
    text +=
        fmt::format("{}{} {}", text.empty() ? "" : ", ", frames.dropped[i], to_string(static_cast<hal::DropReason>(i)));
  }
  return text.empty() ? "none" : text;
}

}  // namespace

std::string readable_bytes(std::uint64_t bytes) {
  constexpr std::array<const char*, 5> kUnits{"B", "kB", "MB", "GB", "TB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (value >= 999.5 && unit + 1 < kUnits.size()) {
    value /= 1000.0;
    ++unit;
  }
  return unit == 0 || value >= 99.95 ? fmt::format("{:.0f} {}", value, kUnits[unit])
                                     : fmt::format("{:.1f} {}", value, kUnits[unit]);
}

std::string readable_count(std::uint64_t count) {
  std::string text = std::to_string(count);
  for (std::size_t place = 3; place < text.size(); place += 4) text.insert(text.size() - place, ",");
  return text;
}

std::string summary_text(const RunReport& report, double run_s, const std::vector<WrittenFile>& files) {
  const FrameCounts& frames = report.frames;
  std::string text = fmt::format("mapped     {} of {} frames in {:.1f} s", frames.integrated, frames.delivered, run_s);
  if (run_s > 0.0) text += fmt::format(", {:.1f} frames/s", static_cast<double>(frames.integrated) / run_s);
  text += fmt::format("\ndropped    {}\n", dropped_text(frames));
  for (const NamedStage& stage : report.stages) {
    if (stage.name != "integrate" || stage.times.count() == 0) continue;
    text += fmt::format("integrate  {:.2f} ms median, {:.2f} ms p99, {:.2f} ms at most\n",
                        stage.times.percentile_us(0.5) / 1e3, stage.times.percentile_us(0.99) / 1e3,
                        stage.times.max_us() / 1e3);
  }
  text += fmt::format("map        {} occupied and {} free voxels of {:g} cm, {} of memory\n",
                      readable_count(report.occupied), readable_count(report.free), report.resolution_m * 100.0,
                      readable_bytes(report.memory_bytes));
  if (report.alignment) {
    const align::AlignReport& counts = report.alignment->counts;
    text += fmt::format("aligned    {} of {} frames, corrected by {:.1f} mm and {:.2f} degrees rms in a step\n",
                        counts.corrected(), frames.delivered, counts.shift_rms_m() * 1e3,
                        counts.turn_rms_rad() * 180.0 / std::numbers::pi);
  }
  if (report.paging) {
    const PagingReport& paging = *report.paging;
    text += fmt::format("window     {:g} m, {} regions went to disk and {} came back, {} were there at the end, {}\n",
                        paging.radius_m, readable_count(paging.regions_out), readable_count(paging.regions_in),
                        readable_count(paging.regions_on_disk), readable_bytes(paging.page_file_bytes));
  }
  for (const std::string& note : report.notes) text += fmt::format("note       {}\n", note);
  std::size_t width = 0;
  for (const WrittenFile& file : files) width = std::max(width, file.path.size());
  for (const WrittenFile& file : files) {
    text += fmt::format("{:<11}{:<{}}  {:>8}  {}\n", &file == files.data() ? "files" : "", file.path, width,
                        readable_bytes(file.bytes), file.what);
  }
  return text;
}

}  // namespace g3d::mapper
