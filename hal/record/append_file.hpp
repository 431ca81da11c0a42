// SPDX-License-Identifier: Apache-2.0
// A file that grows by whole lines or records: each is in it whole or not at all, also on a disk that is full now and
// then, so that what a killed program leaves can be read. Nothing is held back in memory. One thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/result.hpp"

namespace g3d::hal {

class AppendFile {
 public:
  /// An empty file. Errors: those of system_error; no_permission also while another one writes it.
  [[nodiscard]] static Result<AppendFile> create(const std::string& path);
  AppendFile(AppendFile&& other) noexcept;
  AppendFile& operator=(AppendFile&&) = delete;
  ~AppendFile();

  /// 0, or the errno for which the line or record is not in the file.
  [[nodiscard]] int append(std::span<const std::uint8_t> record);
  [[nodiscard]] int append(std::string_view line);
  /// Nothing is appended any more, and another one may begin. 0, or what the disk says of it.
  int close();
  [[nodiscard]] std::uint64_t bytes() const { return static_cast<std::uint64_t>(whole_bytes_); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  AppendFile(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  [[nodiscard]] bool cut_to_whole();

  std::string path_;
  int fd_ = -1;
  std::int64_t whole_bytes_ = 0;
  bool has_half_ = false;
};

}  // namespace g3d::hal
