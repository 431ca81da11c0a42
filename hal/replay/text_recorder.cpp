// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/text_recorder.hpp"

#include <algorithm>
#include <utility>

#include "hal/image/atomic_file.hpp"

namespace g3d::hal {

Result<std::unique_ptr<TextRecorder>> TextRecorder::create(const std::string& path) {
  Result<AppendFile> file = AppendFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<TextRecorder>(new TextRecorder(std::move(file).value()));
}

TextRecorder::TextRecorder(AppendFile file) : file_(std::move(file)), writer_([this] { write_all(); }) {}

TextRecorder::~TextRecorder() { (void)finish(); }

void TextRecorder::put(std::string_view line) {
  Line entry;
  entry.size = static_cast<std::uint8_t>(std::min(line.size(), kMaxLine_bytes));
  std::copy_n(line.begin(), entry.size, entry.text.begin());
  if (line.empty() || line.size() > kMaxLine_bytes || !ring_.try_push(entry)) {
    lost_lines_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  writer_waits_.wake();
}

void TextRecorder::write_all() {
  Line line;
  while (writer_waits_.wait([&] { return ring_.try_pop(line); })) {
    const int error = file_.append(std::string_view(line.text.data(), line.size));
    if (error == 0) continue;
    if (first_errno_ == 0) first_errno_ = error;
    lost_lines_.fetch_add(1, std::memory_order_relaxed);
  }
}

Result<void> TextRecorder::finish() {
  if (writer_.joinable()) {
    writer_waits_.stop();
    writer_.join();
  }
  if (const int error = file_.close(); first_errno_ == 0) first_errno_ = error;
  if (first_errno_ != 0) return system_error(file_.path(), "the recording has a gap", first_errno_);
  return {};
}

}  // namespace g3d::hal
