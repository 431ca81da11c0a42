// SPDX-License-Identifier: Apache-2.0
#include "net/layer_identity.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"
#include "mapper/files/map_header.hpp"
#include "net/wire_parts.hpp"

namespace g3d::net {
namespace {

constexpr std::string_view kIdentityMark = "g3dmap layer 1\n";
constexpr std::size_t kMostIdentity_bytes = 256;

std::uint32_t identity_check(std::string_view text) {
  return mapper::crc32_of({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// Takes "WORD NUMBER\n" from the front of a text.
bool take_line(std::string_view& text, std::string_view word, int base, std::uint64_t& number) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos || end == 0) return false;
  const auto [stopped, failed] = std::from_chars(text.data(), text.data() + end, number, base);
  if (failed != std::errc{} || stopped != text.data() + end) return false;
  text.remove_prefix(end + 1);
  return true;
}

}  // namespace

std::string format_layer_identity(const LayerIdentity& identity) {
  std::string text = fmt::format("{}robot {:016x}\nincarnation {}\nreserved {}\n", kIdentityMark, identity.self.robot,
                                 identity.self.incarnation, identity.reserved);
  return text + fmt::format("check {:08x}\n", identity_check(text));
}

hal::Result<LayerIdentity> parse_layer_identity(std::string_view text, const std::string& name) {
  std::string_view left = text;
  std::uint64_t incarnation = 0;
  std::uint64_t check = 0;
  LayerIdentity identity;
  const bool has_mark = left.starts_with(kIdentityMark);
  if (has_mark) left.remove_prefix(kIdentityMark.size());
  if (!has_mark || !take_line(left, "robot ", 16, identity.self.robot) ||
      !take_line(left, "incarnation ", 10, incarnation) || !take_line(left, "reserved ", 10, identity.reserved) ||
      incarnation > 0xFFFFFFFFU || identity.reserved > kMostVersion) {
    return hal::Error{hal::Reason::malformed,
                      fmt::format("{}: does not say who wrote a layer; the robot begins a new one", name)};
  }
  const std::string_view checked = text.substr(0, text.size() - left.size());
  if (!take_line(left, "check ", 16, check) || !left.empty() || check != identity_check(checked)) {
    return hal::Error{hal::Reason::bad_checksum,
                      fmt::format("{}: its checksum is wrong; check the disk; the robot begins a new layer", name)};
  }
  identity.self.incarnation = static_cast<std::uint32_t>(incarnation);
  return identity;
}

hal::Result<LayerIdentity> read_layer_identity(const std::string& path) {
  const int fd = hal::disk().open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK, 0);
  if (fd < 0) return hal::system_error(path, "cannot open", errno);
  std::array<char, kMostIdentity_bytes> text;
  std::size_t size_bytes = 0;
  while (size_bytes < text.size()) {
    const ssize_t n =
        hal::disk().pread(fd, text.data() + size_bytes, text.size() - size_bytes, static_cast<off_t>(size_bytes));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int failed = errno;
      ::close(fd);
      return hal::system_error(path, "cannot read", failed);
    }
    if (n == 0) break;
    size_bytes += static_cast<std::size_t>(n);
  }
  ::close(fd);
  return parse_layer_identity({text.data(), size_bytes}, path);
}

hal::Result<void> write_layer_identity(const std::string& path, const LayerIdentity& identity) {
  hal::Result<hal::AtomicFile> file = hal::AtomicFile::create(path);
  if (!file) return file.error();
  const hal::Result<void> written = file.value().write(format_layer_identity(identity));
  return written ? file.value().commit() : written;
}

}  // namespace g3d::net
