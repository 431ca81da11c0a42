// SPDX-License-Identifier: Apache-2.0
#include "hal/record/append_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"

namespace g3d::hal {

Result<AppendFile> AppendFile::create(const std::string& path) {
  const int fd = disk().open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return system_error(path, "cannot be made", errno);
  AppendFile file(path, fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return Error{Reason::no_permission, path + ": another robot is recording there; choose another folder"};
  }
  // What is no plain file (a pipe) has nothing to be emptied of.
  if (disk().ftruncate(fd, 0) != 0 && errno != EINVAL) return system_error(path, "cannot be emptied", errno);
  return file;
}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      whole_bytes_(other.whole_bytes_),
      has_half_(other.has_half_) {}

AppendFile::~AppendFile() { (void)close(); }

int AppendFile::close() { return fd_ < 0 || ::close(std::exchange(fd_, -1)) == 0 ? 0 : errno; }

int AppendFile::append(std::string_view line) {
  return append({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
}

int AppendFile::append(std::span<const std::uint8_t> record) {
  if (has_half_ && !cut_to_whole()) return EIO;
  std::size_t done = 0;
  while (done < record.size()) {
    const ssize_t count = disk().write(fd_, record.data() + done, record.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const int error = count < 0 ? errno : EIO;
      has_half_ = done > 0;
      if (has_half_) (void)cut_to_whole();
      return error;
    }
    done += static_cast<std::size_t>(count);
  }
  whole_bytes_ += static_cast<std::int64_t>(record.size());
  return 0;
}

bool AppendFile::cut_to_whole() {
  has_half_ = disk().ftruncate(fd_, whole_bytes_) != 0 || ::lseek(fd_, whole_bytes_, SEEK_SET) != whole_bytes_;
  return !has_half_;
}

}  // namespace g3d::hal
