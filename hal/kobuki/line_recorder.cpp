// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/line_recorder.hpp"

#include <algorithm>
#include <utility>

#include "hal/image/atomic_file.hpp"

namespace g3d::hal::kobuki {
namespace {

constexpr std::size_t kHeader_bytes = sizeof(TimeNs) + sizeof(std::uint16_t);

}  // namespace

Result<std::unique_ptr<LineRecorder>> LineRecorder::create(const std::string& path) {
  Result<AppendFile> file = AppendFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<LineRecorder>(new LineRecorder(std::move(file).value()));
}

LineRecorder::LineRecorder(AppendFile file) : file_(std::move(file)), writer_([this] { write_all(); }) {}

LineRecorder::~LineRecorder() { (void)finish(); }

void LineRecorder::put(std::span<const std::uint8_t> bytes, TimeNs t_ns) {
  while (!bytes.empty()) {
    Chunk chunk;
    chunk.t_ns = t_ns;
    chunk.size = static_cast<std::uint16_t>(std::min(bytes.size(), kChunk_bytes));
    std::copy_n(bytes.begin(), chunk.size, chunk.bytes.begin());
    bytes = bytes.subspan(chunk.size);
    if (!ring_.try_push(chunk)) lost_bytes_.fetch_add(chunk.size, std::memory_order_relaxed);
  }
  writer_waits_.wake();
}

void LineRecorder::write_all() {
  Chunk chunk;
  while (writer_waits_.wait([&] { return ring_.try_pop(chunk); })) write_one(chunk);
}

void LineRecorder::write_one(const Chunk& chunk) {
  std::array<std::uint8_t, kHeader_bytes + kChunk_bytes> record;
  for (std::size_t i = 0; i < sizeof(TimeNs); ++i) {
    record[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(chunk.t_ns) >> (8 * i));
  }
  record[8] = static_cast<std::uint8_t>(chunk.size);
  record[9] = static_cast<std::uint8_t>(chunk.size >> 8);
  std::copy_n(chunk.bytes.begin(), chunk.size, record.begin() + kHeader_bytes);
  const int error = file_.append(std::span<const std::uint8_t>(record.data(), kHeader_bytes + chunk.size));
  if (error == 0) return;
  if (first_errno_ == 0) first_errno_ = error;
  lost_bytes_.fetch_add(chunk.size, std::memory_order_relaxed);
}

Result<void> LineRecorder::finish() {
  if (writer_.joinable()) {
    writer_waits_.stop();
    writer_.join();
  }
  if (const int error = file_.close(); first_errno_ == 0) first_errno_ = error;
  if (first_errno_ != 0) return system_error(file_.path(), "the recording has a gap", first_errno_);
  return {};
}

}  // namespace g3d::hal::kobuki
