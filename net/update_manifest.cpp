// SPDX-License-Identifier: Apache-2.0
#include "net/update_manifest.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "hal/image/atomic_file.hpp"

namespace g3d::net {
namespace {

using hal::Error;
using hal::Reason;

constexpr std::array<std::uint8_t, 8> kManifestMark{'G', '3', 'D', 'M', 'A', 'N', '1', 0};

std::uint64_t chunks_in(std::uint64_t size_bytes) { return (size_bytes + kChunk_bytes - 1) / kChunk_bytes; }

hal::Result<UpdateManifest> manifest_of_open(int fd, const std::string& path, std::uint64_t release) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return hal::system_error(path, "cannot read", errno);
  if (!S_ISREG(status.st_mode))
    return Error{Reason::unsupported, fmt::format("{}: is not a file; give an image", path)};
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size == 0) return Error{Reason::truncated, fmt::format("{}: is empty; make the image again", path)};
  if (size > kMostImage_bytes) {
    return Error{Reason::too_large,
                 fmt::format("{}: has {} bytes, {} is the limit; is it the system's image, and not that "
                             "of a whole disk?",
                             path, size, kMostImage_bytes)};
  }
  UpdateManifest manifest;
  manifest.image.release = release;
  manifest.image.size_bytes = size;
  manifest.chunks.resize(chunks_in(size));
  crypto_generichash_state whole;
  crypto_generichash_init(&whole, nullptr, 0, manifest.image.digest.size());
  std::vector<std::uint8_t> buffer(kChunk_bytes);
  for (std::uint32_t i = 0; i < manifest.chunks.size(); ++i) {
    const std::span part(buffer.data(), manifest.size_of(i));
    for (std::size_t had = 0; had < part.size();) {
      const ssize_t n =
          ::pread(fd, part.data() + had, part.size() - had, static_cast<off_t>(manifest.offset_of(i) + had));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return hal::system_error(path, "cannot read", errno);
      if (n == 0)
        return Error{Reason::truncated,
                     fmt::format("{}: became shorter while it was read; wait until it is made", path)};
      had += static_cast<std::size_t>(n);
    }
    manifest.chunks[i] = digest_of(part);
    crypto_generichash_update(&whole, part.data(), part.size());
  }
  crypto_generichash_final(&whole, manifest.image.digest.data(), manifest.image.digest.size());
  return manifest;
}

}  // namespace

hal::ImageDigest digest_of(std::span<const std::uint8_t> bytes) {
  hal::ImageDigest digest;
  crypto_generichash(digest.data(), digest.size(), bytes.data(), bytes.size(), nullptr, 0);
  return digest;
}

std::size_t UpdateManifest::size_of(std::uint32_t chunk) const {
  return static_cast<std::size_t>(std::min<std::uint64_t>(kChunk_bytes, image.size_bytes - offset_of(chunk)));
}

mapper::Bytes encode_manifest(const UpdateManifest& manifest) {
  mapper::Bytes bytes(kManifestMark.begin(), kManifestMark.end());
  bytes.reserve(kManifestHead_bytes + 32 * manifest.chunks.size());
  mapper::put(bytes, manifest.image.release);
  mapper::put(bytes, manifest.image.size_bytes);
  mapper::put_bytes(bytes, manifest.image.digest);
  for (const hal::ImageDigest& chunk : manifest.chunks) mapper::put_bytes(bytes, chunk);
  return bytes;
}

const char* to_string(ManifestFault fault) {
  switch (fault) {
    case ManifestFault::none:
      return "none";
    case ManifestFault::too_short:
      return "too short";
    case ManifestFault::no_mark:
      return "no mark";
    case ManifestFault::bad_size:
      return "bad size";
    case ManifestFault::bad_length:
      return "bad length";
  }
  return "unknown";
}

ManifestFault decode_manifest(std::span<const std::uint8_t> bytes, UpdateManifest& manifest) {
  if (bytes.size() < kManifestHead_bytes) return ManifestFault::too_short;
  if (!std::equal(kManifestMark.begin(), kManifestMark.end(), bytes.begin())) return ManifestFault::no_mark;
  mapper::ByteReader in(bytes.subspan(kManifestMark.size()));
  UpdateManifest read;
  if (!in.take(read.image.release) || !in.take(read.image.size_bytes) || !in.take(read.image.digest)) {
    return ManifestFault::too_short;
  }
  if (read.image.size_bytes == 0 || read.image.size_bytes > kMostImage_bytes) return ManifestFault::bad_size;
  if (in.left() != 32 * chunks_in(read.image.size_bytes)) return ManifestFault::bad_length;
  read.chunks.resize(in.left() / 32);
  for (hal::ImageDigest& chunk : read.chunks) (void)in.take(chunk);
  manifest = std::move(read);
  return ManifestFault::none;
}

hal::Result<UpdateManifest> manifest_of(const std::string& path, std::uint64_t release) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return hal::system_error(path, "cannot open", errno);
  auto manifest = manifest_of_open(fd, path, release);
  ::close(fd);
  return manifest;
}

}  // namespace g3d::net
