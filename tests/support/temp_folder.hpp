// SPDX-License-Identifier: Apache-2.0
// A folder of its own for one test case, removed with everything in it; and plain writes, to put hostile files there.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace g3d::test {

class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Path of `name` in the folder; sub-folders in it are created.
  [[nodiscard]] std::string operator/(std::string_view name) const;
  /// Names of all entries, sorted, one per line.
  [[nodiscard]] std::string listing() const;

 private:
  std::string path_;
};

void write_plain(const std::string& path, std::string_view text);
void write_plain(const std::string& path, std::span<const std::uint8_t> bytes);
[[nodiscard]] std::string read_plain(const std::string& path);

/// Folder of real recordings (environment G3D_DATA, else the checkout's neighbour), or empty if there is none.
[[nodiscard]] std::string data_folder();

}  // namespace g3d::test
