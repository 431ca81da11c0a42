// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/text_recorder.hpp"

#include <algorithm>
#include <utility>

namespace g3d::hal {

Result<std::unique_ptr<TextRecorder>> TextRecorder::create(const std::string& path) {
  Result<RecordFile> file = RecordFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<TextRecorder>(new TextRecorder(std::move(file).value()));
}

TextRecorder::TextRecorder(RecordFile file) : file_(std::move(file)), writer_([this] { write_all(); }) {}

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
    if (!file_.append({line.text.data(), line.size})) lost_lines_.fetch_add(1, std::memory_order_relaxed);
  }
}

Result<void> TextRecorder::finish() {
  if (writer_.joinable()) {
    writer_waits_.stop();
    writer_.join();
  }
  return file_.close();
}

}  // namespace g3d::hal
