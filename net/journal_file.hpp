// SPDX-License-Identifier: Apache-2.0
// The file that a journal is written to, frame by frame. A frame that the disk did not take as a whole is cut off
// again, so that what is there can be read to its end. Through hal::disk(). One thread.
#pragma once

#include <cstdint>
#include <string>

#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"

namespace g3d::net {

class JournalFile {
 public:
  JournalFile() = default;
  ~JournalFile() { close(); }
  JournalFile(const JournalFile&) = delete;
  JournalFile& operator=(const JournalFile&) = delete;

  /// A journal that is there, to go on behind its first `good_bytes`; what stands behind them is cut off. Errors: those
  /// of the file.
  [[nodiscard]] hal::Result<void> open(const std::string& path, std::uint64_t good_bytes);
  /// An empty one, whatever is there.
  [[nodiscard]] hal::Result<void> create(const std::string& path);
  /// All of it or nothing. After an error the file is closed.
  [[nodiscard]] hal::Result<void> append(mapper::ByteSpan entries);
  /// Until what was appended survives a power cut. After an error the file is closed: nobody knows what it lacks.
  [[nodiscard]] hal::Result<void> sync();
  /// Every frame is read back and compared with its checksum, then the file takes the place of `path`. After an error
  /// with is_at(path) it has, but perhaps not for good.
  [[nodiscard]] hal::Result<void> replace(const std::string& path);
  [[nodiscard]] bool is_at(const std::string& path) const { return is_open() && path_ == path; }
  void close();

  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  [[nodiscard]] hal::Result<void> write_all(mapper::ByteSpan bytes);
  [[nodiscard]] hal::Error fail(std::string_view what);

  std::string path_;
  int fd_ = -1;
  std::uint64_t bytes_ = 0;
  bool is_dirty_ = false;
  mapper::Bytes frame_;
};

}  // namespace g3d::net
