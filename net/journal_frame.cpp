// SPDX-License-Identifier: Apache-2.0
#include "net/journal_frame.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"
#include "mapper/files/map_header.hpp"

namespace g3d::net {
namespace {

constexpr std::size_t kFrameBuffer_bytes = 1 << 20;

std::uint32_t frame_checksum(std::uint32_t length, mapper::ByteSpan entries) {
  return mapper::crc32_of(entries, mapper::crc32_of({reinterpret_cast<const std::uint8_t*>(&length), sizeof length}));
}

}  // namespace

void add_frame(mapper::Bytes& out, mapper::ByteSpan entries) {
  const auto length = static_cast<std::uint32_t>(entries.size());
  mapper::put(out, length);
  mapper::put(out, frame_checksum(length, entries));
  mapper::put_bytes(out, entries);
}

FrameReader::~FrameReader() {
  if (fd_ >= 0) ::close(fd_);
}

hal::Result<void> FrameReader::open(const std::string& path) {
  path_ = path;
  // O_NONBLOCK: a named pipe in place of the file must not stop the reader.
  fd_ = hal::disk().open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK, 0);
  if (fd_ < 0) return hal::system_error(path, "cannot open", errno);
  struct stat status {};
  if (::fstat(fd_, &status) != 0) return hal::system_error(path, "cannot read", errno);
  file_bytes_ = S_ISREG(status.st_mode) ? static_cast<std::uint64_t>(status.st_size) : 0;
  auto mark = bytes_at(0, kJournalMark.size());
  if (!mark) return mark.error();
  if (!std::equal(mark.value().begin(), mark.value().end(), kJournalMark.begin(), kJournalMark.end())) {
    return hal::Error{
        hal::Reason::unsupported,
        fmt::format("{}: is no journal of layers of this version; move it away, and the robot begins anew "
                    "with what others give it",
                    path)};
  }
  at_ = good_bytes_ = kJournalMark.size();
  return {};
}

hal::Result<mapper::ByteSpan> FrameReader::bytes_at(std::uint64_t at, std::size_t count) {
  if (at >= file_bytes_) return mapper::ByteSpan{};
  count = static_cast<std::size_t>(std::min<std::uint64_t>(count, file_bytes_ - at));
  if (at < buffer_at_ || at + count > buffer_at_ + buffer_.size()) {
    buffer_at_ = at;
    buffer_.resize(
        static_cast<std::size_t>(std::min<std::uint64_t>(std::max(kFrameBuffer_bytes, count), file_bytes_ - at)));
    for (std::size_t had = 0; had < buffer_.size();) {
      const ssize_t n =
          hal::disk().pread(fd_, buffer_.data() + had, buffer_.size() - had, static_cast<off_t>(at + had));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) {
        const int error = errno;
        buffer_.clear();
        return hal::system_error(path_, "cannot be read", error);
      }
      if (n == 0) buffer_.resize(had);  // it has become shorter
      had += static_cast<std::size_t>(n);
    }
  }
  const auto offset = static_cast<std::size_t>(at - buffer_at_);
  return mapper::ByteSpan(buffer_).subspan(offset, std::min(count, buffer_.size() - offset));
}

hal::Result<bool> FrameReader::read_frame(std::uint64_t at, std::uint32_t& length_bytes) {
  length_bytes = 0;
  auto head = bytes_at(at, kFrameHead_bytes);
  if (!head) return head.error();
  std::uint32_t length = 0;
  std::uint32_t checksum = 0;
  mapper::ByteReader in(head.value());
  if (!in.take(length) || !in.take(checksum) || length == 0 || length > kMostFrame_bytes) return false;
  auto all = bytes_at(at, kFrameHead_bytes + length);
  if (!all) return all.error();
  if (all.value().size() < kFrameHead_bytes + length) return false;
  length_bytes = length;
  entries_ = all.value().subspan(kFrameHead_bytes);
  return frame_checksum(length, entries_) == checksum;
}

hal::Result<FrameReader::Next> FrameReader::next() {
  std::uint32_t length = 0;
  auto whole = read_frame(at_, length);
  if (!whole) return whole.error();
  if (!whole.value()) {
    for (std::uint64_t after = at_; length != 0;) {
      after += kFrameHead_bytes + length;
      auto follows = read_frame(after, length);
      if (!follows) return follows.error();
      if (!follows.value()) continue;
      at_ = after;
      return Next::damaged;
    }
    return Next::end;
  }
  at_ += kFrameHead_bytes + length;
  good_bytes_ = at_;
  return Next::frame;
}

}  // namespace g3d::net
