// SPDX-License-Identifier: Apache-2.0
// What an update consists of: the image's size and digest, and the digest of every 64 KiB of it, so that each piece is
// known to be right before it is written, and a machine finds out by looking at its own disk which ones it still lacks.
//
//   0  "G3DMAN1\0"    8  u64 release    16  u64 size_bytes    24  BLAKE2b-256 of the image    56  and of each chunk
//
// Little-endian. Pure but for manifest_of; any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/boot/slots.hpp"
#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"

namespace g3d::net {

inline constexpr std::size_t kChunk_bytes = 64 * 1024;
inline constexpr std::uint64_t kMostImage_bytes = std::uint64_t{1} << 30;
inline constexpr std::size_t kMostChunks = kMostImage_bytes / kChunk_bytes;
inline constexpr std::size_t kManifestHead_bytes = 56;
inline constexpr std::size_t kMostManifest_bytes = kManifestHead_bytes + 32 * kMostChunks;

[[nodiscard]] hal::ImageDigest digest_of(std::span<const std::uint8_t> bytes);

struct UpdateManifest {
  hal::SlotImageId image;
  std::vector<hal::ImageDigest> chunks;

  [[nodiscard]] std::uint64_t offset_of(std::uint32_t chunk) const { return std::uint64_t{chunk} * kChunk_bytes; }
  /// All but the last have kChunk_bytes.
  [[nodiscard]] std::size_t size_of(std::uint32_t chunk) const;
  bool operator==(const UpdateManifest&) const = default;
};

[[nodiscard]] mapper::Bytes encode_manifest(const UpdateManifest& manifest);

enum class ManifestFault : std::uint8_t {
  none,
  too_short,
  no_mark,
  bad_size,    ///< no image at all, or larger than any machine takes
  bad_length,  ///< not one digest for each chunk
};
[[nodiscard]] const char* to_string(ManifestFault fault);

/// `manifest` is written to only if the answer is `none`.
[[nodiscard]] ManifestFault decode_manifest(std::span<const std::uint8_t> bytes, UpdateManifest& manifest);

/// Of a file. Errors: not_found, no_permission, truncated (empty), too_large, io_error.
[[nodiscard]] hal::Result<UpdateManifest> manifest_of(const std::string& path, std::uint64_t release);

}  // namespace g3d::net
