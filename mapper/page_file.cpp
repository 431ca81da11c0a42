// SPDX-License-Identifier: Apache-2.0
#include "mapper/page_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"

namespace g3d::mapper {
namespace {

class NamelessFile final : public PageFile {
 public:
  NamelessFile(int fd, std::string name) : fd_(fd), name_(std::move(name)) {}
  ~NamelessFile() override { ::close(fd_); }
  NamelessFile(const NamelessFile&) = delete;
  NamelessFile& operator=(const NamelessFile&) = delete;

  hal::Result<void> write(std::uint64_t offset, std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const ssize_t n = hal::disk().pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return hal::system_error(name_, "cannot be written", errno);
      bytes = bytes.subspan(static_cast<std::size_t>(n));
      offset += static_cast<std::uint64_t>(n);
    }
    return {};
  }

  hal::Result<void> read(std::uint64_t offset, std::span<std::uint8_t> out) override {
    while (!out.empty()) {
      const ssize_t n = hal::disk().pread(fd_, out.data(), out.size(), static_cast<off_t>(offset));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return hal::system_error(name_, "cannot be read", errno);
      if (n == 0) {
        return hal::Error{hal::Reason::truncated,
                          fmt::format("{}: byte {}: ends too early; check the disk", name_, offset)};
      }
      out = out.subspan(static_cast<std::size_t>(n));
      offset += static_cast<std::uint64_t>(n);
    }
    return {};
  }

  hal::Result<void> truncate(std::uint64_t bytes) override {
    if (hal::disk().ftruncate(fd_, static_cast<off_t>(bytes)) != 0) {
      return hal::system_error(name_, "cannot be shortened", errno);
    }
    return {};
  }

 private:
  int fd_;
  std::string name_;
};

}  // namespace

hal::Result<std::unique_ptr<PageFile>> create_page_file(const std::string& folder) {
  std::string path = folder + "/.pages-XXXXXX";
  const int fd = ::mkostemp(path.data(), O_CLOEXEC);
  if (fd < 0) return hal::system_error(folder + "/.pages", "cannot be created", errno);
  ::unlink(path.c_str());
  return std::unique_ptr<PageFile>(std::make_unique<NamelessFile>(fd, folder + "/.pages"));
}

}  // namespace g3d::mapper
