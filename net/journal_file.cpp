// SPDX-License-Identifier: Apache-2.0
#include "net/journal_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"
#include "net/journal_frame.hpp"

namespace g3d::net {
namespace {

constexpr int kJournalFlags = O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;

hal::Result<void> sync_folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
  const int fd = hal::disk().open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0);
  if (fd < 0) return hal::system_error(folder, "cannot open", errno);
  const int failed = hal::disk().fsync(fd) == 0 ? 0 : errno;
  ::close(fd);
  // File systems that keep no folders to sync.
  if (failed == 0 || failed == EINVAL || failed == ENOTSUP) return {};
  return hal::system_error(folder, "cannot be synced", failed);
}

}  // namespace

hal::Error JournalFile::fail(std::string_view what) {
  const int failed = errno;
  close();
  return hal::system_error(path_, what, failed);
}

void JournalFile::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

hal::Result<void> JournalFile::open(const std::string& path, std::uint64_t good_bytes) {
  close();
  path_ = path;
  fd_ = hal::disk().open(path.c_str(), kJournalFlags & ~O_CREAT, 0);
  if (fd_ < 0) return fail("cannot open");
  if (hal::disk().ftruncate(fd_, static_cast<off_t>(good_bytes)) != 0) return fail("cannot be shortened");
  if (::lseek(fd_, 0, SEEK_END) != static_cast<off_t>(good_bytes)) return fail("cannot be continued");
  bytes_ = good_bytes;
  is_dirty_ = true;
  return {};
}

hal::Result<void> JournalFile::create(const std::string& path) {
  close();
  path_ = path;
  fd_ = hal::disk().open(path.c_str(), kJournalFlags, 0666);
  if (fd_ < 0) return fail("cannot create");
  if (hal::disk().ftruncate(fd_, 0) != 0) return fail("cannot empty");
  bytes_ = 0;
  is_dirty_ = true;
  const mapper::ByteSpan mark{reinterpret_cast<const std::uint8_t*>(kJournalMark.data()), kJournalMark.size()};
  if (const auto written = write_all(mark); !written) return written;
  if (const auto synced = sync(); !synced) return synced;
  const auto placed = sync_folder_of(path);
  if (!placed) close();
  return placed;
}

hal::Result<void> JournalFile::write_all(mapper::ByteSpan bytes) {
  for (mapper::ByteSpan left = bytes; !left.empty();) {
    const ssize_t n = hal::disk().write(fd_, left.data(), left.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int failed = errno;
      // Half a frame is no frame; a reader would end there as well.
      (void)hal::disk().ftruncate(fd_, static_cast<off_t>(bytes_));
      errno = failed;
      return fail("cannot be written");
    }
    left = left.subspan(static_cast<std::size_t>(n));
  }
  bytes_ += bytes.size();
  is_dirty_ = true;
  return {};
}

hal::Result<void> JournalFile::append(mapper::ByteSpan entries) {
  frame_.clear();
  add_frame(frame_, entries);
  return write_all(frame_);
}

hal::Result<void> JournalFile::sync() {
  if (!is_dirty_) return {};
  if (hal::disk().fsync(fd_) != 0) return fail("cannot be synced");
  is_dirty_ = false;
  return {};
}

hal::Result<void> JournalFile::replace(const std::string& path) {
  if (const auto synced = sync(); !synced) return synced;
  // Disks have been seen to lose bytes without a word.
  FrameReader reader;
  if (const auto opened = reader.open(path_); !opened) return opened;
  for (auto next = FrameReader::Next::frame; next == FrameReader::Next::frame;) {
    auto read = reader.next();
    if (!read) return read.error();
    next = read.value();
  }
  if (reader.good_bytes() != bytes_) {
    return hal::Error{hal::Reason::bad_checksum,
                      fmt::format("{}: byte {}: is not what was written; check the disk", path_, reader.good_bytes())};
  }
  if (hal::disk().rename(path_.c_str(), path.c_str()) != 0) return fail("cannot be renamed");
  path_ = path;
  return sync_folder_of(path);
}

}  // namespace g3d::net
