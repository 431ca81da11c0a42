// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/line_recorder.hpp"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "hal/disk.hpp"

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
      return {Reason::disk_full, what + "; free some space; the recording has a gap there"};
    default:
      return {Reason::io_error, what + "; check the disk, the recording has a gap there"};
  }
}

constexpr std::size_t kHeader_bytes = sizeof(TimeNs) + sizeof(std::uint16_t);

}  // namespace

Result<std::unique_ptr<LineRecorder>> LineRecorder::create(const std::string& path) {
  const int fd = disk().open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return file_error(path, errno);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(fd);
    return Error{Reason::no_permission, path + ": another robot is recording there; choose another folder"};
  }
  // What is no plain file (a pipe) has nothing to be emptied of.
  if (disk().ftruncate(fd, 0) != 0 && errno != EINVAL) {
    const int error = errno;
    ::close(fd);
    return file_error(path, error);
  }
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

  std::size_t done = 0;
  const std::size_t size = kHeader_bytes + chunk.size;
  bool is_refused = ends_in_half_a_record_ && !cut_to_whole_records();
  while (!is_refused && done < size) {
    const ssize_t count = disk().write(fd_, record.data() + done, size - done);
    if (count > 0) done += static_cast<std::size_t>(count);
    if (count < 0 && errno != EINTR) {
      if (first_errno_ == 0) first_errno_ = errno;
      is_refused = true;
    }
  }
  if (!is_refused) {
    whole_bytes_ += static_cast<std::int64_t>(size);
    return;
  }
  lost_bytes_.fetch_add(chunk.size, std::memory_order_relaxed);
  ends_in_half_a_record_ |= done > 0;
}

// After half a record nothing may follow: the reader could not find the next one.
bool LineRecorder::cut_to_whole_records() {
  ends_in_half_a_record_ =
      disk().ftruncate(fd_, whole_bytes_) != 0 || ::lseek(fd_, whole_bytes_, SEEK_SET) != whole_bytes_;
  return !ends_in_half_a_record_;
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
