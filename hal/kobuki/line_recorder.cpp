// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/line_recorder.hpp"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace g3d::hal::kobuki {
namespace {

Error file_error(const std::string& path, int error) {
  const char* const text = ::strerrordesc_np(error);
  const std::string what = path + ": " + (text != nullptr ? text : "cannot be written");
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return {Reason::not_found, what + "; make its folder first"};
    case EACCES:
    case EPERM:
    case EROFS:
      return {Reason::no_permission, what + "; choose another folder"};
    case ENOSPC:
    case EDQUOT:
      return {Reason::disk_full, what + "; free some space, the recording is cut there"};
    default:
      return {Reason::io_error, what};
  }
}

constexpr std::size_t kHeader_bytes = sizeof(TimeNs) + sizeof(std::uint16_t);

}  // namespace

Result<std::unique_ptr<LineRecorder>> LineRecorder::create(const std::string& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return file_error(path, errno);
  return std::unique_ptr<LineRecorder>(new LineRecorder(path, fd));
}

LineRecorder::LineRecorder(std::string path, int fd)
    : path_(std::move(path)), fd_(fd), writer_([this] { write_all(); }) {}

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

  // After half a record nothing may follow: the reader could not find the next one.
  std::size_t done = 0;
  const std::size_t size = kHeader_bytes + chunk.size;
  while (first_errno_ == 0 && done < size) {
    const ssize_t count = ::write(fd_, record.data() + done, size - done);
    if (count > 0) done += static_cast<std::size_t>(count);
    if (count < 0 && errno != EINTR) first_errno_ = errno;
  }
  if (done < size) lost_bytes_.fetch_add(chunk.size, std::memory_order_relaxed);
}

Result<void> LineRecorder::finish() {
  if (writer_.joinable()) {
    writer_waits_.stop();
    writer_.join();
  }
  if (fd_ >= 0 && ::close(std::exchange(fd_, -1)) != 0 && first_errno_ == 0) first_errno_ = errno;
  if (first_errno_ != 0) return file_error(path_, first_errno_);
  return {};
}

}  // namespace g3d::hal::kobuki
