// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/frame_reader.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace g3d::hal {
namespace {

// Behind so many messages with wrong images there is no telling messages from pixels: then all that waits is given up.
// It also bounds how often the same bytes are summed up.
constexpr int kMostBadInARow = 4;

}  // namespace

const char* to_string(StreamReject reject) {
  switch (reject) {
    case StreamReject::no_magic:
      return "no_magic";
    case StreamReject::bad_header:
      return "bad_header";
    case StreamReject::other_version:
      return "other_version";
    case StreamReject::too_large:
      return "too_large";
    case StreamReject::bad_image:
      return "bad_image";
    case StreamReject::count_:
      break;
  }
  return "unknown";
}

FrameStreamReader::FrameStreamReader(std::size_t most_pixels)
    : most_message_bytes_(kFrameHeader_bytes + 5 * most_pixels),
      capacity_(2 * most_message_bytes_),
      bytes_(std::make_unique<std::uint8_t[]>(capacity_)) {}

std::span<std::uint8_t> FrameStreamReader::room() {
  // Moved once per message at most, as there is room for two.
  if (begin_ > 0 && capacity_ - begin_ < most_message_bytes_) {
    std::memmove(bytes_.get(), bytes_.get() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  return {bytes_.get() + end_, capacity_ - end_};
}

void FrameStreamReader::take(std::size_t count) { end_ += std::min(count, capacity_ - end_); }

void FrameStreamReader::refuse(StreamReject reject) { ++rejects_[static_cast<std::size_t>(reject)]; }

/// Moves on to where a message begins, or may begin with what is still to come.
void FrameStreamReader::find_magic() {
  const std::size_t from = begin_;
  for (; begin_ < end_; ++begin_) {
    const void* const found = std::memchr(bytes_.get() + begin_, kFrameMagic.front(), end_ - begin_);
    if (found == nullptr) {
      begin_ = end_;
      break;
    }
    begin_ = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes_.get());
    const std::size_t known = std::min(kFrameMagic.size(), end_ - begin_);
    if (std::memcmp(bytes_.get() + begin_, kFrameMagic.data(), known) == 0) break;
  }
  if (begin_ == from) return;
  skipped_bytes_ += begin_ - from;
  refuse(StreamReject::no_magic);
}

FrameStreamReader::Got FrameStreamReader::next() {
  for (;;) {
    find_magic();
    if (end_ - begin_ < kFrameHeader_bytes) return Got::nothing;
    FrameHeader header;
    const std::uint8_t* const start = bytes_.get() + begin_;
    const HeaderFault fault =
        decode_frame_header(std::span<const std::uint8_t, kFrameHeader_bytes>(start, kFrameHeader_bytes), header);
    if (fault != HeaderFault::none || kFrameHeader_bytes + header.image_bytes() > most_message_bytes_) {
      refuse(fault == HeaderFault::none            ? StreamReject::too_large
             : fault == HeaderFault::other_version ? StreamReject::other_version
                                                   : StreamReject::bad_header);
      ++begin_;
      ++skipped_bytes_;
      continue;
    }
    const std::size_t message_bytes = kFrameHeader_bytes + header.image_bytes();
    if (end_ - begin_ < message_bytes) return Got::nothing;
    if (::crc32_z(0, start + kFrameHeader_bytes, header.image_bytes()) != header.image_crc) {
      refuse(StreamReject::bad_image);
      const bool is_hopeless = ++bad_in_a_row_ >= kMostBadInARow;
      const std::size_t skipped = is_hopeless ? end_ - begin_ : 1;
      if (is_hopeless) bad_in_a_row_ = 0;
      begin_ += skipped;
      skipped_bytes_ += skipped;
      continue;
    }
    bad_in_a_row_ = 0;
    header_ = header;
    image_at_ = begin_ + kFrameHeader_bytes;
    begin_ += message_bytes;
    return header.has_image ? Got::image : Got::sign_of_life;
  }
}

void FrameStreamReader::copy_to(Frame& out) const {
  const std::size_t pixels = header_.camera.pixel_count();
  out.stamp_ns = header_.stamp_ns;
  out.sequence = header_.sequence;
  out.has_colour = header_.has_colour;
  std::memcpy(out.depth.get(), bytes_.get() + image_at_, 2 * pixels);
  if (header_.has_colour) std::memcpy(out.rgb.get(), bytes_.get() + image_at_ + 2 * pixels, 3 * pixels);
}

}  // namespace g3d::hal
