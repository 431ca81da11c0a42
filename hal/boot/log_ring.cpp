// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/log_ring.hpp"

#include <errno.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "hal/image/atomic_file.hpp"

namespace g3d::hal::boot {
namespace {
constexpr std::size_t kMostLogLine_bytes = 1000;
}

LogRing::~LogRing() { close(); }

void LogRing::close() {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
}

std::string LogRing::path(int number) const { return fmt::format("{}/{}.log", folder_, number); }

bool LogRing::begin(int number, bool anew) {
  if (fd_ >= 0) ::close(fd_);
  fd_ = ::open(path(number).c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | (anew ? O_TRUNC : 0), 0644);
  number_ = number;
  struct stat found {};
  written_bytes_ = fd_ >= 0 && ::fstat(fd_, &found) == 0 ? static_cast<std::size_t>(found.st_size) : 0;
  return fd_ >= 0;
}

Result<void> LogRing::open(const std::string& folder) {
  folder_ = folder;
  if (::mkdir(folder.c_str(), 0755) != 0 && errno != EEXIST) return system_error(folder, "cannot be made", errno);
  // The one written last. PID 1 sets the clock before, which never goes back (wall_clock.hpp).
  int newest = 0;
  std::int64_t newest_ns = INT64_MIN;
  for (int i = 0; i < bounds_.files; ++i) {
    struct stat found {};
    if (::stat(path(i).c_str(), &found) != 0) continue;
    const std::int64_t at_ns = found.st_mtim.tv_sec * 1'000'000'000LL + found.st_mtim.tv_nsec;
    if (at_ns < newest_ns) continue;
    newest = i;
    newest_ns = at_ns;
  }
  if (!begin(newest, false)) return system_error(path(newest), "cannot be opened", errno);
  return {};
}

void LogRing::write(std::string_view line) {
  std::string text(line.substr(0, kMostLogLine_bytes));
  text += '\n';
  if (fd_ >= 0 && written_bytes_ + text.size() > bounds_.file_bytes) (void)begin((number_ + 1) % bounds_.files, true);
  const ssize_t wrote = fd_ >= 0 ? ::write(fd_, text.data(), text.size()) : -1;
  if (wrote != static_cast<ssize_t>(text.size())) ++lost_lines_;
  written_bytes_ += static_cast<std::size_t>(std::max<ssize_t>(wrote, 0));
}

std::string LogRing::tail(std::size_t most_bytes) const {
  const int fd = ::open(path(number_).c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return {};
  const std::size_t size = std::min(most_bytes, written_bytes_);
  std::string text(size, '\0');
  const ssize_t got = ::pread(fd, text.data(), size, static_cast<off_t>(written_bytes_ - size));
  ::close(fd);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  if (size < written_bytes_) text.erase(0, std::min(text.find('\n') + 1, text.size()));  // not half a line
  return text;
}

}  // namespace g3d::hal::boot
