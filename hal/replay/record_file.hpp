// SPDX-License-Identifier: Apache-2.0
// A file that records are appended to, each whole or not at all: after half a record a reader could not find the next
// one. What a disk refuses is lost, and what comes once it takes records again follows whole. What was written survives
// the death of the process. One thread at a time.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "hal/result.hpp"

namespace g3d::hal {

class RecordFile {
 public:
  /// An empty file. Errors: not_found, no_permission (also while another one writes it), disk_full, io_error.
  [[nodiscard]] static Result<RecordFile> create(const std::string& path);
  RecordFile(RecordFile&& other) noexcept;
  RecordFile& operator=(RecordFile&&) = delete;
  ~RecordFile();

  /// False if the record is not in the file.
  [[nodiscard]] bool append(std::span<const std::uint8_t> record);
  /// Nothing is appended any more. Errors: disk_full, io_error, with the first that occurred.
  [[nodiscard]] Result<void> close();
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  RecordFile(std::string path, int fd);
  [[nodiscard]] bool cut_to_whole_records();

  std::string path_;
  int fd_;
  int first_errno_ = 0;
  std::int64_t whole_bytes_ = 0;
  bool ends_in_half_a_record_ = false;
};

}  // namespace g3d::hal
