// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/frame_reader.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "hal/frame_pool.hpp"

using namespace g3d::hal;

namespace {

using Bytes = std::vector<std::uint8_t>;

CameraModel tiny_camera() {
  CameraModel camera;
  camera.width_px = 8;
  camera.height_px = 6;
  return camera;
}

Bytes image_message(std::uint64_t sequence, bool has_colour = true) {
  const CameraModel camera = tiny_camera();
  Frame frame = make_frame(camera);
  frame.sequence = sequence;
  frame.stamp_ns = static_cast<TimeNs>(sequence) * 1000;
  frame.has_colour = has_colour;
  for (std::size_t i = 0; i < camera.pixel_count(); ++i) {
    frame.depth[i] = static_cast<std::uint16_t>(i * 7 + sequence);
  }
  Bytes bytes(most_message_bytes(camera));
  bytes.resize(encode_frame_message(camera, frame, 100, bytes));
  return bytes;
}

Bytes sign_message() {
  Bytes bytes(kFrameHeader_bytes);
  (void)encode_sign_of_life(tiny_camera(), 9, 100, bytes);
  return bytes;
}

Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

struct Read {
  std::vector<std::uint64_t> images;
  int signs = 0;
  std::array<std::uint64_t, kStreamRejects> rejects{};
  std::uint64_t skipped = 0;
  std::size_t pending = 0;
};

/// In pieces of `piece` bytes.
Read read_all(const Bytes& stream, std::size_t piece) {
  FrameStreamReader reader(tiny_camera().pixel_count());
  Read read;
  for (std::size_t at = 0; at < stream.size();) {
    const std::span<std::uint8_t> room = reader.room();
    REQUIRE_FALSE(room.empty());
    const std::size_t count = std::min({piece, room.size(), stream.size() - at});
    std::copy_n(stream.begin() + static_cast<std::ptrdiff_t>(at), count, room.begin());
    reader.take(count);
    at += count;
    for (auto got = reader.next(); got != FrameStreamReader::Got::nothing; got = reader.next()) {
      if (got == FrameStreamReader::Got::image) {
        read.images.push_back(reader.header().sequence);
      } else {
        ++read.signs;
      }
    }
  }
  read.rejects = reader.rejects();
  read.skipped = reader.skipped_bytes();
  read.pending = reader.pending_bytes();
  return read;
}

std::uint64_t count_of(const Read& read, StreamReject reject) { return read.rejects[static_cast<std::size_t>(reject)]; }

}  // namespace

TEST_CASE("messages are found whole, however the bytes are cut") {
  const Bytes stream = joined({image_message(1), sign_message(), image_message(2, false), image_message(3)});
  for (const std::size_t piece : {1, 7, 63, 64, 65, 300, 4096}) {
    INFO(piece);
    const Read read = read_all(stream, piece);
    CHECK(read.images == std::vector<std::uint64_t>{1, 2, 3});
    CHECK(read.signs == 1);
    CHECK(read.skipped == 0);
    CHECK(read.pending == 0);
    CHECK(std::accumulate(read.rejects.begin(), read.rejects.end(), std::uint64_t{0}) == 0);
  }
}

TEST_CASE("an image comes out of the stream as it went in") {
  FrameStreamReader reader(tiny_camera().pixel_count());
  const Bytes message = image_message(40);
  std::copy(message.begin(), message.end(), reader.room().begin());
  reader.take(message.size());
  REQUIRE(reader.next() == FrameStreamReader::Got::image);
  Frame frame = make_frame(tiny_camera());
  reader.copy_to(frame);
  CHECK(frame.sequence == 40);
  CHECK(frame.stamp_ns == 40'000);
  CHECK(frame.has_colour);
  CHECK(frame.depth[5] == 75);
  CHECK(reader.next() == FrameStreamReader::Got::nothing);
}

TEST_CASE("a stream that begins in the middle, or has rubbish in it, is found again") {
  Bytes half = image_message(1);
  half.erase(half.begin(), half.begin() + 100);
  const Bytes rubbish = {'g', '3', 'd', 'f', 'g', '3', 'g', 'g', 0, 1, 2};
  for (const std::size_t piece : {1, 50, 4096}) {
    INFO(piece);
    const Read read = read_all(joined({half, image_message(2), rubbish, image_message(3)}), piece);
    CHECK(read.images == std::vector<std::uint64_t>{2, 3});
    CHECK(read.skipped == half.size() + rubbish.size());
    CHECK(count_of(read, StreamReject::no_magic) >= 2);
  }
}

TEST_CASE("a message that lost bytes costs itself alone") {
  Bytes torn = image_message(2);
  torn.erase(torn.begin() + 80, torn.begin() + 90);
  const Read read = read_all(joined({image_message(1), torn, image_message(3), image_message(4)}), 33);
  CHECK(read.images == std::vector<std::uint64_t>{1, 3, 4});
  CHECK(count_of(read, StreamReject::bad_image) == 1);
}

TEST_CASE("wrong pixels and wrong headers are refused and counted") {
  Bytes wrong_pixel = image_message(1);
  wrong_pixel[100] ^= 1;
  Bytes wrong_header = image_message(2);
  wrong_header[20] ^= 1;
  const Read read = read_all(joined({wrong_pixel, wrong_header, image_message(3)}), 4096);
  CHECK(read.images == std::vector<std::uint64_t>{3});
  CHECK(count_of(read, StreamReject::bad_image) == 1);
  CHECK(count_of(read, StreamReject::bad_header) == 1);
}

TEST_CASE("a camera of more pixels than there is room for is named as such") {
  CameraModel large = tiny_camera();
  large.height_px = 60;
  Bytes message(most_message_bytes(large));
  Frame frame = make_frame(large);
  message.resize(encode_frame_message(large, frame, 100, message));
  const Read read = read_all(joined({message, image_message(3)}), 500);
  CHECK(read.images == std::vector<std::uint64_t>{3});
  CHECK(count_of(read, StreamReject::too_large) == 1);
}

TEST_CASE("many wrong images in a row make the reader give up what it holds, and go on with what comes") {
  Bytes bad = image_message(1);
  bad.back() ^= 1;
  const Read read = read_all(joined({bad, bad, bad, bad, bad, image_message(2), image_message(3)}), 17);
  CHECK(read.images.back() == 3);
  CHECK(count_of(read, StreamReject::bad_image) >= 4);
}

TEST_CASE("every reason has a name") {
  for (std::size_t i = 0; i < kStreamRejects; ++i) {
    CHECK(std::string(to_string(static_cast<StreamReject>(i))) != "unknown");
  }
}
