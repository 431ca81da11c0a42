// SPDX-License-Identifier: Apache-2.0
// Depth frames as messages of a byte stream, from a camera in another program or machine. Little-endian:
//
//    at  bytes
//     0      8  "g3dframe"
//     8      2  version, 1
//    10      2  bit 0: an image follows, bit 1: with colour; without any it is a sign of life
//    12      2  width   in pixels, 1 to 2048, also of a sign of life
//    14      2  height
//    16      8  sequence number, counted by the camera
//    24      8  stamp   in ns of the sender's clock
//    32     20  fx fy cx cy in pixels, depth units per metre: 5 floats
//    52      4  how slow the sender's clock is: hundredths of a second that pass in one of its seconds, 100 to 10000
//    56      4  CRC-32 of the image's bytes
//    60      4  CRC-32 of the 60 bytes above
//    64         2 bytes per pixel of depth, then 3 (R G B) per pixel of colour registered to it
//
// A stream may begin anywhere and lose bytes: who reads it looks for the next message that is whole.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/messages.hpp"

namespace g3d::hal {

inline constexpr std::string_view kFrameMagic = "g3dframe";
inline constexpr std::size_t kFrameHeader_bytes = 64;
inline constexpr std::uint16_t kFrameVersion = 1;
inline constexpr std::uint32_t kLeastSlow_percent = 100;
inline constexpr std::uint32_t kMostSlow_percent = 10'000;

struct FrameHeader {
  CameraModel camera;
  std::uint64_t sequence = 0;
  TimeNs stamp_ns = 0;
  bool has_image = false;
  bool has_colour = false;
  std::uint32_t slow_percent = kLeastSlow_percent;
  std::uint32_t image_crc = 0;

  /// What follows the header.
  [[nodiscard]] std::size_t image_bytes() const { return has_image ? (has_colour ? 5 : 2) * camera.pixel_count() : 0; }
};

/// Of the largest message of this camera.
[[nodiscard]] inline std::size_t most_message_bytes(const CameraModel& camera) {
  return kFrameHeader_bytes + 5 * camera.pixel_count();
}

/// A message of one frame; `out` has room for the largest one. Returns its size. Allocates nothing.
std::size_t encode_frame_message(const CameraModel& camera, const Frame& frame, std::uint32_t slow_percent,
                                 std::span<std::uint8_t> out);
/// A message without an image.
std::size_t encode_sign_of_life(const CameraModel& camera, TimeNs stamp_ns, std::uint32_t slow_percent,
                                std::span<std::uint8_t> out);

enum class HeaderFault : std::uint8_t { none, no_magic, bad_checksum, other_version, out_of_range };
/// The first kFrameHeader_bytes of a message. Nothing is taken over from one with a fault.
[[nodiscard]] HeaderFault decode_frame_header(std::span<const std::uint8_t, kFrameHeader_bytes> bytes,
                                              FrameHeader& header);

}  // namespace g3d::hal
