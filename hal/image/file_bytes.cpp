// SPDX-License-Identifier: Apache-2.0
#include "hal/image/file_bytes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace g3d::hal {
namespace {

// Reads until the end of the file; it may have grown or shrunk since its size was asked.
template <typename Bytes>
Result<void> read_open_file(int fd, const std::string& path, std::size_t max_bytes, Bytes& bytes) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return system_error(path, "cannot read", errno);
  if (!S_ISREG(status.st_mode)) {
    return Error{Reason::unsupported, fmt::format("{}: is not a regular file; give the path of a file", path)};
  }
  if (static_cast<std::uint64_t>(status.st_size) > max_bytes) {
    return Error{Reason::too_large, fmt::format("{}: has {} bytes, at most {} are accepted; is it the right file?",
                                                path, status.st_size, max_bytes)};
  }
  bytes.resize(static_cast<std::size_t>(status.st_size));
  std::size_t done_bytes = 0;
  while (done_bytes < bytes.size()) {
    const ssize_t n = ::read(fd, bytes.data() + done_bytes, bytes.size() - done_bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path, "cannot read", errno);
    if (n == 0) break;
    done_bytes += static_cast<std::size_t>(n);
  }
  bytes.resize(done_bytes);
  return {};
}

template <typename Bytes>
Result<void> read_whole(const std::string& path, std::size_t max_bytes, Bytes& bytes) {
  bytes.clear();
  // O_NONBLOCK: a named pipe in place of the file must not stop the reader.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return system_error(path, "cannot open", errno);
  Result<void> result = read_open_file(fd, path, max_bytes, bytes);
  ::close(fd);
  if (!result) bytes.clear();
  return result;
}

}  // namespace

Result<void> read_file_into(const std::string& path, std::size_t max_bytes, std::vector<std::uint8_t>& bytes) {
  return read_whole(path, max_bytes, bytes);
}

Result<std::vector<std::uint8_t>> read_file(const std::string& path, std::size_t max_bytes) {
  std::vector<std::uint8_t> bytes;
  if (Result<void> read = read_whole(path, max_bytes, bytes); !read) return read.error();
  return bytes;
}

Result<std::string> read_text_file(const std::string& path, std::size_t max_bytes) {
  std::string text;
  if (Result<void> read = read_whole(path, max_bytes, text); !read) return read.error();
  return text;
}

Result<void> write_file_atomic(const std::string& path, std::span<const std::uint8_t> bytes) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  if (Result<void> written = file.value().write(bytes); !written) return written;
  return file.value().commit();
}

Result<void> write_file_atomic(const std::string& path, std::string_view text) {
  return write_file_atomic(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

}  // namespace g3d::hal
