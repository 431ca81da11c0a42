// SPDX-License-Identifier: Apache-2.0
// A camera's byte stream from hostile hands, in pieces of any size. Whatever comes out is an image of a size that there
// is room for; every byte was part of a message, skipped, or still waits. With an odd first byte the checksum of every
// header is made right before, so that what is behind it is reached.
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/stream/frame_reader.hpp"

namespace {

void check(bool holds) {
  if (!holds) std::abort();
}

void repair(std::vector<std::uint8_t>& bytes) {
  using namespace g3d::hal;
  for (std::size_t at = 0; at + kFrameHeader_bytes <= bytes.size(); ++at) {
    if (std::memcmp(bytes.data() + at, kFrameMagic.data(), kFrameMagic.size()) != 0) continue;
    const auto crc = static_cast<std::uint32_t>(::crc32_z(0, bytes.data() + at, kFrameHeader_bytes - 4));
    std::memcpy(bytes.data() + at + kFrameHeader_bytes - 4, &crc, sizeof crc);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  if (size_bytes < 2 || size_bytes > 4096) return -1;
  CameraModel camera;
  camera.width_px = 8;
  camera.height_px = 6;
  std::vector<std::uint8_t> bytes(data + 1, data + size_bytes);
  if (data[0] % 2 == 1) repair(bytes);
  const std::size_t piece = 1 + data[0] / 2;
  FrameStreamReader reader(camera.pixel_count());
  std::size_t in_messages = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::span<std::uint8_t> room = reader.room();
    check(!room.empty());
    const std::size_t count = std::min({piece, room.size(), bytes.size() - at});
    std::memcpy(room.data(), bytes.data() + at, count);
    reader.take(count);
    at += count;
    for (auto got = reader.next(); got != FrameStreamReader::Got::nothing; got = reader.next()) {
      const FrameHeader& header = reader.header();
      check(header.has_image == (got == FrameStreamReader::Got::image));
      check(kFrameHeader_bytes + header.image_bytes() <= most_message_bytes(camera));
      in_messages += kFrameHeader_bytes + header.image_bytes();
      if (got != FrameStreamReader::Got::image) continue;
      Frame frame = make_frame(header.camera);
      reader.copy_to(frame);
    }
  }
  check(in_messages + reader.skipped_bytes() + reader.pending_bytes() == bytes.size());
  return 0;
}
