// SPDX-License-Identifier: Apache-2.0
// A journal as a file: a mark, then frames, each with its length and a checksum. What is written together is a frame:
// after a power cut it is there as a whole, or the journal ends before it.
//
//   "g3dmap layers 1\n"   then   length (u32)   CRC-32 of length and entries (u32)   entries ...
//
// A frame that is damaged in the middle is passed over where its length still leads to the next one. Files are read
// through hal::disk(). One thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"

namespace g3d::net {

inline constexpr std::string_view kJournalMark = "g3dmap layers 1\n";
inline constexpr std::size_t kFrameHead_bytes = 8;
inline constexpr std::size_t kMostFrame_bytes = 256 * 1024;

/// `entries`: 1 to kMostFrame_bytes of them.
void add_frame(mapper::Bytes& out, mapper::ByteSpan entries);

/// Reads a journal from its beginning.
class FrameReader {
 public:
  enum class Next : std::uint8_t {
    frame,
    damaged,  ///< one or more, whose checksums are wrong; a whole frame follows
    end,      ///< nothing follows that can be read
  };

  FrameReader() = default;
  ~FrameReader();
  FrameReader(const FrameReader&) = delete;
  FrameReader& operator=(const FrameReader&) = delete;

  /// Errors: not_found; those of the file; unsupported, if it is no journal of this version.
  [[nodiscard]] hal::Result<void> open(const std::string& path);
  /// Errors: those of the file.
  [[nodiscard]] hal::Result<Next> next();
  /// Of the last frame, until the next call.
  [[nodiscard]] mapper::ByteSpan entries() const { return entries_; }
  /// Where the last readable frame ends.
  [[nodiscard]] std::uint64_t good_bytes() const { return good_bytes_; }
  [[nodiscard]] std::uint64_t file_bytes() const { return file_bytes_; }

 private:
  /// The frame at a place of the file, or nothing. `length_bytes`: of the frame by its head; 0: of no frame.
  [[nodiscard]] hal::Result<bool> read_frame(std::uint64_t at, std::uint32_t& length_bytes);
  [[nodiscard]] hal::Result<mapper::ByteSpan> bytes_at(std::uint64_t at, std::size_t count);

  std::string path_;
  int fd_ = -1;
  std::uint64_t file_bytes_ = 0;
  std::uint64_t good_bytes_ = 0;
  std::uint64_t at_ = 0;
  mapper::Bytes buffer_;
  std::uint64_t buffer_at_ = 0;
  mapper::ByteSpan entries_;
};

}  // namespace g3d::net
