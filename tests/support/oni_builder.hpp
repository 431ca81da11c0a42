// SPDX-License-Identifier: Apache-2.0
// Small .oni files by hand, good ones and bad ones.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace g3d::test {

using OniBytes = std::vector<std::uint8_t>;

/// Puts an .oni file together record by record (see hal/kinect/oni_check.hpp for the format).
class OniBuilder {
 public:
  explicit OniBuilder(std::uint32_t highest_node = 2, std::uint64_t last_stamp_us = 1'000'000);
  void node(std::uint32_t id, std::string_view name, std::uint32_t type, std::string_view code, std::uint32_t frames);
  void int_property(std::uint32_t node, std::string_view key, std::uint64_t value);
  void property(std::uint32_t node, std::string_view key, const OniBytes& value, std::uint32_t type = 6);
  /// What a depth or image node needs, and ready.
  void describe(std::uint32_t node, bool is_depth, std::uint32_t width, std::uint32_t height);
  void bare(std::uint32_t node, std::uint32_t type);  ///< 7 removed, 9 ready, 0x0B end
  void data_begin(std::uint32_t node);
  void image(std::uint32_t node, std::uint64_t stamp_us, std::uint32_t number, const OniBytes& data);
  [[nodiscard]] const OniBytes& bytes() const { return bytes_; }
  [[nodiscard]] OniBytes& bytes() { return bytes_; }

 private:
  void record(std::uint32_t node, std::uint32_t type, const OniBytes& fields, const OniBytes& data);
  OniBytes bytes_;
};

/// 16zT code of an image in which every pixel is `mm`.
[[nodiscard]] OniBytes flat_depth_code(std::size_t pixels, std::uint16_t mm);
/// Plain RGB of one value.
[[nodiscard]] OniBytes flat_rgb(std::size_t pixels, std::uint8_t value);
/// A whole file: depth (16zT, 1000 mm + 10 per image) and plain colour, `frames` of each.
[[nodiscard]] OniBytes small_oni(std::uint32_t width, std::uint32_t height, std::uint32_t frames);

}  // namespace g3d::test
