// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/record_file.hpp"

#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "hal/disk.hpp"

namespace g3d::hal {
namespace {

Error record_file_error(const std::string& path, int error) {
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

Result<RecordFile> RecordFile::create(const std::string& path) {
  const int fd = disk().open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return record_file_error(path, errno);
  RecordFile file(path, fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return Error{Reason::no_permission, path + ": another robot is recording there; choose another folder"};
  }
  // What is no plain file (a pipe) has nothing to be emptied of.
  if (disk().ftruncate(fd, 0) != 0 && errno != EINVAL) return record_file_error(path, errno);
  return file;
}

RecordFile::RecordFile(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}

RecordFile::RecordFile(RecordFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      first_errno_(other.first_errno_),
      whole_bytes_(other.whole_bytes_),
      ends_in_half_a_record_(other.ends_in_half_a_record_) {}

RecordFile::~RecordFile() { (void)close(); }

bool RecordFile::append(std::span<const std::uint8_t> record) {
  std::size_t done = 0;
  bool is_refused = ends_in_half_a_record_ && !cut_to_whole_records();
  while (!is_refused && done < record.size()) {
    const ssize_t count = disk().write(fd_, record.data() + done, record.size() - done);
    if (count > 0) done += static_cast<std::size_t>(count);
    if (count < 0 && errno != EINTR) {
      if (first_errno_ == 0) first_errno_ = errno;
      is_refused = true;
    }
  }
  if (is_refused) {
    ends_in_half_a_record_ |= done > 0;
  } else {
    whole_bytes_ += static_cast<std::int64_t>(record.size());
  }
  return !is_refused;
}

bool RecordFile::cut_to_whole_records() {
  ends_in_half_a_record_ =
      disk().ftruncate(fd_, whole_bytes_) != 0 || ::lseek(fd_, whole_bytes_, SEEK_SET) != whole_bytes_;
  return !ends_in_half_a_record_;
}

Result<void> RecordFile::close() {
  if (fd_ >= 0 && ::close(std::exchange(fd_, -1)) != 0 && first_errno_ == 0) first_errno_ = errno;
  if (first_errno_ != 0) return record_file_error(path_, first_errno_);
  return {};
}

}  // namespace g3d::hal
