// SPDX-License-Identifier: Apache-2.0
#include "net/private_text.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "hal/image/atomic_file.hpp"

namespace g3d::net {
namespace {

using hal::Error;
using hal::Reason;

hal::Result<void> read_opened(int fd, const std::string& path, std::string_view what, std::string_view if_seen,
                              PrivateText& text) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return hal::system_error(path, "cannot read", errno);
  if (!S_ISREG(status.st_mode)) {
    return Error{Reason::unsupported, fmt::format("{}: is not a regular file; give the path of a {}", path, what)};
  }
  if ((status.st_mode & 0077) != 0) {
    return Error{Reason::no_permission,
                 fmt::format("{}: others may read or change this key (mode {:04o}); chmod 600 {}, and {} if they may "
                             "have",
                             path, status.st_mode & 07777, path, if_seen)};
  }
  if (status.st_uid != ::geteuid() && ::geteuid() != 0) {
    return Error{Reason::no_permission, fmt::format("{}: belongs to another user; make it your own with chown", path)};
  }
  while (text.size_bytes < text.bytes.size()) {
    const ssize_t n = ::read(fd, text.bytes.data() + text.size_bytes, text.bytes.size() - text.size_bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return hal::system_error(path, "cannot read", errno);
    if (n == 0) return {};
    text.size_bytes += static_cast<std::size_t>(n);
  }
  return Error{Reason::too_large, fmt::format("{}: has more than {} bytes, which no {} has; is it the right file?",
                                              path, PrivateText::kMost_bytes, what)};
}

}  // namespace

PrivateText::~PrivateText() { sodium_memzero(bytes.data(), bytes.size()); }

hal::Result<void> read_private_text(const std::string& path, std::string_view what, std::string_view if_seen,
                                    PrivateText& text) {
  // O_NONBLOCK: a named pipe in place of the file must not stop the reader.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return hal::system_error(path, "cannot open", errno);
  hal::Result<void> read = read_opened(fd, path, what, if_seen, text);
  ::close(fd);
  return read;
}

}  // namespace g3d::net
