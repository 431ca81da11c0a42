// SPDX-License-Identifier: Apache-2.0
// Finds whole frame messages in a byte stream: see frame_message.hpp. What is not whole is skipped and counted. One
// thread; allocates at construction only.
//
//   bytes come:  n = read(fd, reader.room()); reader.take(n);
//   then:        while ((got = reader.next()) != FrameStreamReader::Got::nothing) ...
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "hal/messages.hpp"
#include "hal/stream/frame_message.hpp"

namespace g3d::hal {

enum class StreamReject : std::uint8_t {
  no_magic,    ///< bytes that belong to no message, however many there were at a time
  bad_header,  ///< its checksum is wrong, or it says what cannot be
  other_version,
  too_large,  ///< an image of more pixels than there is room for
  bad_image,  ///< its checksum is wrong
  count_,
};
[[nodiscard]] const char* to_string(StreamReject reject);
inline constexpr std::size_t kStreamRejects = static_cast<std::size_t>(StreamReject::count_);

class FrameStreamReader {
 public:
  enum class Got : std::uint8_t { nothing, sign_of_life, image };

  /// Images of up to so many pixels.
  explicit FrameStreamReader(std::size_t most_pixels);

  /// Where the next bytes may be put; never empty. Ends what next() gave.
  [[nodiscard]] std::span<std::uint8_t> room();
  void take(std::size_t count);
  /// The next message, until there is `nothing` more without further bytes.
  [[nodiscard]] Got next();
  /// Of the last message.
  [[nodiscard]] const FrameHeader& header() const { return header_; }
  /// The last image; `out` has storage for its pixels. Stamp and number are as the message has them.
  void copy_to(Frame& out) const;

  /// Bytes that wait for the rest of their message.
  [[nodiscard]] std::size_t pending_bytes() const { return end_ - begin_; }
  /// Another stream begins.
  void clear() { begin_ = end_ = 0; }
  [[nodiscard]] const std::array<std::uint64_t, kStreamRejects>& rejects() const { return rejects_; }
  [[nodiscard]] std::uint64_t skipped_bytes() const { return skipped_bytes_; }

 private:
  void find_magic();
  void refuse(StreamReject reject);

  std::size_t most_message_bytes_;
  std::size_t capacity_;
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  FrameHeader header_;
  std::size_t image_at_ = 0;
  int bad_in_a_row_ = 0;
  std::array<std::uint64_t, kStreamRejects> rejects_{};
  std::uint64_t skipped_bytes_ = 0;
};

}  // namespace g3d::hal
