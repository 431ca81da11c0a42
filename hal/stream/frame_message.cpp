// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/frame_message.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

namespace g3d::hal {
namespace {

static_assert(std::endian::native == std::endian::little, "pixels travel as they lie in memory");

constexpr std::uint16_t kHasImage = 1;
constexpr std::uint16_t kHasColour = 2;
constexpr std::size_t kChecked_bytes = kFrameHeader_bytes - 4;

// Places in the header.
constexpr std::size_t kVersionAt = 8, kFlagsAt = 10, kWidthAt = 12, kHeightAt = 14, kSequenceAt = 16, kStampAt = 24;
constexpr std::size_t kModelAt = 32, kSlowAt = 52, kImageCrcAt = 56;

std::uint32_t crc_of(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(::crc32_z(0, bytes.data(), bytes.size()));
}

template <typename T>
void put(std::span<std::uint8_t> bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <typename T>
T get(std::span<const std::uint8_t> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void write_header(const FrameHeader& header, std::span<std::uint8_t> out) {
  std::memcpy(out.data(), kFrameMagic.data(), kFrameMagic.size());
  put(out, kVersionAt, kFrameVersion);
  const int flags = (header.has_image ? kHasImage : 0) | (header.has_colour ? kHasColour : 0);
  put(out, kFlagsAt, static_cast<std::uint16_t>(flags));
  put(out, kWidthAt, static_cast<std::uint16_t>(header.camera.width_px));
  put(out, kHeightAt, static_cast<std::uint16_t>(header.camera.height_px));
  put(out, kSequenceAt, header.sequence);
  put(out, kStampAt, header.stamp_ns);
  put(out, kModelAt,
      std::array{header.camera.fx_px, header.camera.fy_px, header.camera.cx_px, header.camera.cy_px,
                 header.camera.depth_units_per_metre});
  put(out, kSlowAt, header.slow_percent);
  put(out, kImageCrcAt, header.image_crc);
  put(out, kChecked_bytes, crc_of(out.first(kChecked_bytes)));
}

bool is_in_range(const FrameHeader& header) {
  const CameraModel& camera = header.camera;
  const auto is_side = [](int px) { return px >= 1 && px <= kMaxImageSide_px; };
  // NaN is in no range.
  const auto is_within = [](float x, float low, float high) { return x >= low && x <= high; };
  return is_side(camera.width_px) && is_side(camera.height_px) && is_within(camera.fx_px, 1.0F, 1e5F) &&
         is_within(camera.fy_px, 1.0F, 1e5F) && is_within(camera.cx_px, -4096.0F, 4096.0F) &&
         is_within(camera.cy_px, -4096.0F, 4096.0F) && is_within(camera.depth_units_per_metre, 1.0F, 1e6F) &&
         header.slow_percent >= kLeastSlow_percent && header.slow_percent <= kMostSlow_percent &&
         (header.has_image || !header.has_colour) && header.stamp_ns >= 0;
}

}  // namespace

std::size_t encode_frame_message(const CameraModel& camera, const Frame& frame, std::uint32_t slow_percent,
                                 std::span<std::uint8_t> out) {
  assert(out.size() >= most_message_bytes(camera));
  FrameHeader header{camera, frame.sequence, frame.stamp_ns, true, frame.has_colour, slow_percent, 0};
  const std::size_t depth_bytes = 2 * camera.pixel_count();
  std::memcpy(out.data() + kFrameHeader_bytes, frame.depth.get(), depth_bytes);
  if (frame.has_colour) {
    std::memcpy(out.data() + kFrameHeader_bytes + depth_bytes, frame.rgb.get(), 3 * camera.pixel_count());
  }
  header.image_crc = crc_of(out.subspan(kFrameHeader_bytes, header.image_bytes()));
  write_header(header, out);
  return kFrameHeader_bytes + header.image_bytes();
}

std::size_t encode_sign_of_life(const CameraModel& camera, TimeNs stamp_ns, std::uint32_t slow_percent,
                                std::span<std::uint8_t> out) {
  assert(out.size() >= kFrameHeader_bytes);
  write_header({camera, 0, stamp_ns, false, false, slow_percent, crc_of({})}, out);
  return kFrameHeader_bytes;
}

HeaderFault decode_frame_header(std::span<const std::uint8_t, kFrameHeader_bytes> bytes, FrameHeader& header) {
  if (!std::equal(kFrameMagic.begin(), kFrameMagic.end(), bytes.begin())) return HeaderFault::no_magic;
  if (get<std::uint32_t>(bytes, kChecked_bytes) != crc_of(bytes.first(kChecked_bytes))) {
    return HeaderFault::bad_checksum;
  }
  if (get<std::uint16_t>(bytes, kVersionAt) != kFrameVersion) return HeaderFault::other_version;
  FrameHeader read;
  const auto flags = get<std::uint16_t>(bytes, kFlagsAt);
  read.has_image = (flags & kHasImage) != 0;
  read.has_colour = (flags & kHasColour) != 0;
  read.camera.width_px = get<std::uint16_t>(bytes, kWidthAt);
  read.camera.height_px = get<std::uint16_t>(bytes, kHeightAt);
  read.sequence = get<std::uint64_t>(bytes, kSequenceAt);
  read.stamp_ns = get<TimeNs>(bytes, kStampAt);
  const auto model = get<std::array<float, 5>>(bytes, kModelAt);
  read.camera.fx_px = model[0];
  read.camera.fy_px = model[1];
  read.camera.cx_px = model[2];
  read.camera.cy_px = model[3];
  read.camera.depth_units_per_metre = model[4];
  read.slow_percent = get<std::uint32_t>(bytes, kSlowAt);
  read.image_crc = get<std::uint32_t>(bytes, kImageCrcAt);
  if ((flags & ~(kHasImage | kHasColour)) != 0 || !is_in_range(read)) return HeaderFault::out_of_range;
  header = read;
  return HeaderFault::none;
}

}  // namespace g3d::hal
