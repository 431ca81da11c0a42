// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/text_recorder.hpp"

#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "hal/disk.hpp"

namespace g3d::hal {
namespace {

Error recording_error(const std::string& path, int error) {
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
      return {Reason::disk_full, what + "; free some space; the recording has a gap there"};
    default:
      return {Reason::io_error, what + "; check the disk, the recording has a gap there"};
  }
}

}  // namespace

Result<std::unique_ptr<TextRecorder>> TextRecorder::create(const std::string& path) {
  const int fd = disk().open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return recording_error(path, errno);
  return std::unique_ptr<TextRecorder>(new TextRecorder(path, fd));
}

TextRecorder::TextRecorder(std::string path, int fd)
    : path_(std::move(path)), fd_(fd), writer_([this] { write_all(); }) {}

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
  while (writer_waits_.wait([&] { return ring_.try_pop(line); })) write_one(line);
}

void TextRecorder::write_one(const Line& line) {
  std::size_t done = 0;
  bool is_refused = ends_in_half_a_line_ && !cut_to_whole_lines();
  while (!is_refused && done < line.size) {
    const ssize_t count = disk().write(fd_, line.text.data() + done, line.size - done);
    if (count > 0) done += static_cast<std::size_t>(count);
    if (count < 0 && errno != EINTR) {
      if (first_errno_ == 0) first_errno_ = errno;
      is_refused = true;
    }
  }
  if (!is_refused) {
    whole_bytes_ += line.size;
    return;
  }
  lost_lines_.fetch_add(1, std::memory_order_relaxed);
  ends_in_half_a_line_ |= done > 0;
}

bool TextRecorder::cut_to_whole_lines() {
  ends_in_half_a_line_ =
      disk().ftruncate(fd_, whole_bytes_) != 0 || ::lseek(fd_, whole_bytes_, SEEK_SET) != whole_bytes_;
  return !ends_in_half_a_line_;
}

Result<void> TextRecorder::finish() {
  if (writer_.joinable()) {
    writer_waits_.stop();
    writer_.join();
  }
  if (fd_ >= 0 && ::close(std::exchange(fd_, -1)) != 0 && first_errno_ == 0) first_errno_ = errno;
  if (first_errno_ != 0) return recording_error(path_, first_errno_);
  return {};
}

}  // namespace g3d::hal
