// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/frame_message.hpp"

#include <zlib.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <vector>

#include "hal/frame_pool.hpp"

using namespace g3d::hal;

namespace {

CameraModel small_camera() {
  CameraModel camera;
  camera.width_px = 4;
  camera.height_px = 3;
  camera.fx_px = 5.25F;
  return camera;
}

Frame numbered_frame(const CameraModel& camera) {
  Frame frame = make_frame(camera);
  frame.stamp_ns = 123'456'789'012;
  frame.sequence = 77;
  frame.has_colour = true;
  for (std::size_t i = 0; i < camera.pixel_count(); ++i) frame.depth[i] = static_cast<std::uint16_t>(1000 + 300 * i);
  for (std::size_t i = 0; i < 3 * camera.pixel_count(); ++i) frame.rgb[i] = static_cast<std::uint8_t>(i);
  return frame;
}

using HeaderBytes = std::span<const std::uint8_t, kFrameHeader_bytes>;

HeaderFault decode(const std::vector<std::uint8_t>& bytes, FrameHeader& header) {
  return decode_frame_header(HeaderBytes(bytes.data(), kFrameHeader_bytes), header);
}

template <typename T>
void overwrite(std::vector<std::uint8_t>& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
  const auto crc = static_cast<std::uint32_t>(::crc32(0, bytes.data(), 60));
  std::memcpy(bytes.data() + 60, &crc, sizeof crc);
}

}  // namespace

TEST_CASE("a frame message says what the frame is, at the places that the format names") {
  const CameraModel camera = small_camera();
  const Frame frame = numbered_frame(camera);
  std::vector<std::uint8_t> bytes(most_message_bytes(camera));
  REQUIRE(encode_frame_message(camera, frame, 400, bytes) == 64 + 5 * 12);
  CHECK(std::memcmp(bytes.data(), "g3dframe\1\0\3\0\4\0\3\0\x4d\0\0\0\0\0\0\0", 24) == 0);
  CHECK(bytes[64] == 0xe8);
  CHECK(bytes[65] == 0x03);
  CHECK(bytes[64 + 24 + 5] == 5);
  FrameHeader header;
  REQUIRE(decode(bytes, header) == HeaderFault::none);
  CHECK(header.camera == camera);
  CHECK(header.stamp_ns == frame.stamp_ns);
  CHECK(header.sequence == 77);
  CHECK(header.has_image);
  CHECK(header.has_colour);
  CHECK(header.slow_percent == 400);
  CHECK(header.image_bytes() == 60);
}

TEST_CASE("a message without colour is shorter, and a sign of life is a header") {
  const CameraModel camera = small_camera();
  Frame frame = numbered_frame(camera);
  frame.has_colour = false;
  std::vector<std::uint8_t> bytes(most_message_bytes(camera));
  CHECK(encode_frame_message(camera, frame, 100, bytes) == 64 + 2 * 12);
  REQUIRE(encode_sign_of_life(camera, 5, 100, bytes) == 64);
  FrameHeader header;
  REQUIRE(decode(bytes, header) == HeaderFault::none);
  CHECK_FALSE(header.has_image);
  CHECK(header.image_bytes() == 0);
  CHECK(header.stamp_ns == 5);
}

TEST_CASE("a header with any bit wrong is refused, and nothing is taken over from it") {
  const CameraModel camera = small_camera();
  std::vector<std::uint8_t> good(most_message_bytes(camera));
  (void)encode_frame_message(camera, numbered_frame(camera), 100, good);
  for (std::size_t bit = 0; bit < 8 * kFrameHeader_bytes; ++bit) {
    std::vector<std::uint8_t> bytes = good;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    FrameHeader header;
    header.sequence = 3;
    INFO(bit);
    CHECK(decode(bytes, header) == (bit < 64 ? HeaderFault::no_magic : HeaderFault::bad_checksum));
    CHECK(header.sequence == 3);
  }
}

TEST_CASE("a header with a right checksum that says what cannot be is refused") {
  const CameraModel camera = small_camera();
  std::vector<std::uint8_t> good(most_message_bytes(camera));
  (void)encode_frame_message(camera, numbered_frame(camera), 100, good);
  const auto fault_with = [&](std::size_t at, auto value) {
    std::vector<std::uint8_t> bytes = good;
    overwrite(bytes, at, value);
    FrameHeader header;
    return decode(bytes, header);
  };
  CHECK(fault_with(8, std::uint16_t{2}) == HeaderFault::other_version);
  CHECK(fault_with(10, std::uint16_t{7}) == HeaderFault::out_of_range);
  CHECK(fault_with(10, std::uint16_t{2}) == HeaderFault::out_of_range);  // colour without an image
  CHECK(fault_with(12, std::uint16_t{0}) == HeaderFault::out_of_range);
  CHECK(fault_with(14, std::uint16_t{2049}) == HeaderFault::out_of_range);
  CHECK(fault_with(24, std::int64_t{-1}) == HeaderFault::out_of_range);
  CHECK(fault_with(32, std::numeric_limits<float>::quiet_NaN()) == HeaderFault::out_of_range);
  CHECK(fault_with(36, 0.0F) == HeaderFault::out_of_range);
  CHECK(fault_with(40, std::numeric_limits<float>::infinity()) == HeaderFault::out_of_range);
  CHECK(fault_with(48, 0.0F) == HeaderFault::out_of_range);
  CHECK(fault_with(52, std::uint32_t{99}) == HeaderFault::out_of_range);
  CHECK(fault_with(52, std::uint32_t{200}) == HeaderFault::none);
}
