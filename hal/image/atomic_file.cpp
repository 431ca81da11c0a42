// SPDX-License-Identifier: Apache-2.0
#include "hal/image/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hal/disk.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kBuffer_bytes = 256 * 1024;

std::string part_of(const std::string& path) { return path + ".part"; }

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::uint32_t checksum_of(std::uint32_t before, std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(::crc32_z(before, bytes.data(), bytes.size()));
}

// Returns 0 or errno.
int write_all(int fd, const std::uint8_t* data, std::size_t size_bytes) {
  while (size_bytes > 0) {
    const ssize_t n = disk().write(fd, data, size_bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    data += n;
    size_bytes -= static_cast<std::size_t>(n);
  }
  return 0;
}

// The rename itself must survive a power cut, not only the bytes.
int sync_folder(const std::string& folder) {
  const int fd = disk().open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0);
  if (fd < 0) return errno;
  int failed = disk().fsync(fd) == 0 ? 0 : errno;
  if (failed == EINVAL || failed == ENOTSUP) failed = 0;  // file systems that keep no folders to sync
  ::close(fd);
  return failed;
}

bool is_the_file_at(int fd, const std::string& path) {
  struct stat opened {};
  struct stat named {};
  return ::fstat(fd, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

// A part that was there before may have been opened by others: then what is written next would be theirs to read.
Result<void> make_private(int fd, const std::string& part) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return system_error(part, "cannot write", errno);
  if (status.st_uid != ::geteuid() || status.st_nlink != 1 || (status.st_mode & 0077) != 0) {
    return Error{Reason::no_permission,
                 fmt::format("{}: is there already, and others can get at it; remove it and try again", part)};
  }
  return {};
}

}  // namespace

Error system_error(const std::string& path, std::string_view what, int errno_value) {
  Reason reason = Reason::io_error;
  std::string_view remedy = "check the disk";
  switch (errno_value) {
    case ENOENT:
    case ENOTDIR:
      reason = Reason::not_found;
      remedy = "check the path; folders must exist";
      break;
    case EACCES:
    case EPERM:
    case EROFS:
    case EISDIR:
    case ETXTBSY:
      reason = Reason::no_permission;
      remedy = "choose another path or change its permissions";
      break;
    case ENOSPC:
    case EDQUOT:
      reason = Reason::disk_full;
      remedy = "free some space or choose another folder";
      break;
    case EFBIG:
      reason = Reason::too_large;
      remedy = "raise the file size limit";
      break;
    case EMFILE:
    case ENFILE:
      remedy = "raise the limit of open files";
      break;
    default:
      break;
  }
  return {reason, fmt::format("{}: {}: {}; {}", path, what, std::strerror(errno_value), remedy)};
}

Result<AtomicFile> AtomicFile::create(const std::string& path) { return create(path, false); }

Result<AtomicFile> AtomicFile::create_private(const std::string& path) { return create(path, true); }

Result<AtomicFile> AtomicFile::create(const std::string& path, bool is_private) {
  const std::string part = part_of(path);
  for (;;) {
    // For reading as well: see what_came_back().
    const int fd =
        disk().open(part.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, is_private ? 0600 : 0666);
    if (fd < 0) return system_error(part, "cannot create", errno);
    // Other failures mean a file system without locks: then two writers at once are the user's affair.
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(fd);
      return Error{Reason::no_permission, fmt::format("{}: is being written by another process; wait for it", part)};
    }
    // Between open and lock another writer may have renamed or removed the part: then the lock is on a stranger.
    if (!is_the_file_at(fd, part)) {
      ::close(fd);
      continue;
    }
    if (disk().ftruncate(fd, 0) != 0) {
      const int failed = errno;
      ::close(fd);
      return system_error(part, "cannot empty", failed);
    }
    if (is_private) {
      if (const Result<void> made = make_private(fd, part); !made) {
        ::close(fd);
        return made.error();
      }
    }
    return AtomicFile(path, fd, is_private);
  }
}

AtomicFile::AtomicFile(std::string path, int fd, bool is_private)
    : path_(std::move(path)),
      fd_(fd),
      is_private_(is_private),
      buffer_(std::make_unique<std::uint8_t[]>(kBuffer_bytes)),
      error_{Reason::bad_usage, path_ + ": was closed already; open it again"} {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      is_private_(other.is_private_),
      buffer_(std::move(other.buffer_)),
      buffered_bytes_(other.buffered_bytes_),
      checksum_(other.checksum_),
      bytes_written_(other.bytes_written_),
      error_(std::move(other.error_)) {}

AtomicFile::~AtomicFile() {
  abandon();
  if (is_private_ && buffer_) ::explicit_bzero(buffer_.get(), kBuffer_bytes);
}

Error AtomicFile::fail(std::string_view what, int errno_value) {
  error_ = system_error(path_, what, errno_value);
  abandon();
  return error_;
}

Result<void> AtomicFile::flush() {
  const int failed = write_all(fd_, buffer_.get(), std::exchange(buffered_bytes_, 0));
  if (failed != 0) return fail("cannot write", failed);
  return {};
}

Result<void> AtomicFile::write(std::span<const std::uint8_t> bytes) {
  if (fd_ < 0) return error_;
  bytes_written_ += bytes.size();
  checksum_ = checksum_of(checksum_, bytes);
  while (!bytes.empty()) {
    const std::size_t n = std::min(bytes.size(), kBuffer_bytes - buffered_bytes_);
    std::memcpy(buffer_.get() + buffered_bytes_, bytes.data(), n);
    buffered_bytes_ += n;
    bytes = bytes.subspan(n);
    if (buffered_bytes_ == kBuffer_bytes) {
      if (Result<void> flushed = flush(); !flushed) return flushed;
    }
  }
  return {};
}

Result<void> AtomicFile::write(std::string_view text) {
  return write(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

// A disk that fails may take bytes and keep others. The kernel's own copy of what is safe is given up first, so that it
// is the disk that answers, as far as anybody can ask it to.
Result<void> AtomicFile::check_what_came_back() {
  (void)::posix_fadvise(fd_, 0, 0, POSIX_FADV_DONTNEED);
  std::uint32_t checksum = 0;
  std::uint64_t offset = 0;
  while (offset < bytes_written_) {
    const std::size_t wanted = std::min<std::uint64_t>(kBuffer_bytes, bytes_written_ - offset);
    const ssize_t n = disk().pread(fd_, buffer_.get(), wanted, static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail("cannot be read back", errno);
    if (n == 0) break;
    checksum = checksum_of(checksum, {buffer_.get(), static_cast<std::size_t>(n)});
    offset += static_cast<std::uint64_t>(n);
  }
  if (offset == bytes_written_ && checksum == checksum_) return {};
  error_ = {
      Reason::bad_checksum,
      fmt::format("{}: what was read back is not what was written; the disk fails, choose a folder on another one",
                  path_)};
  abandon();
  return error_;
}

Result<void> AtomicFile::commit() {
  if (fd_ < 0) return error_;
  if (Result<void> flushed = flush(); !flushed) return flushed;
  if (disk().fsync(fd_) != 0) return fail("cannot write", errno);
  if (Result<void> read_back = check_what_came_back(); !read_back) return read_back;
  if (disk().rename(part_of(path_).c_str(), path_.c_str()) != 0) return fail("cannot replace", errno);
  ::close(std::exchange(fd_, -1));
  if (const int failed = sync_folder(folder_of(path_)); failed != 0) {
    error_ = system_error(path_, "cannot sync its folder", failed);
    return error_;
  }
  return {};
}

void AtomicFile::abandon() {
  if (fd_ < 0) return;
  ::unlink(part_of(path_).c_str());  // before the lock goes with the descriptor
  ::close(std::exchange(fd_, -1));
}

}  // namespace g3d::hal
