// SPDX-License-Identifier: Apache-2.0
#include "hal/record/append_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"

namespace g3d::hal {

Result<AppendFile> AppendFile::create(const std::string& path) {
  const int fd = disk().open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return system_error(path, "cannot be made", errno);
  return AppendFile(path, fd);
}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      whole_bytes_(other.whole_bytes_),
      has_half_(other.has_half_) {}

AppendFile::~AppendFile() {
  if (fd_ >= 0) ::close(fd_);
}

int AppendFile::append(std::string_view text) {
  if (has_half_ && !cut_to_whole()) return EIO;
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = disk().write(fd_, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const int error = count < 0 ? errno : EIO;
      has_half_ = done > 0;
      if (has_half_) (void)cut_to_whole();
      return error;
    }
    done += static_cast<std::size_t>(count);
  }
  whole_bytes_ += static_cast<std::int64_t>(text.size());
  return 0;
}

bool AppendFile::cut_to_whole() {
  has_half_ = disk().ftruncate(fd_, whole_bytes_) != 0 || ::lseek(fd_, whole_bytes_, SEEK_SET) != whole_bytes_;
  return !has_half_;
}

}  // namespace g3d::hal
