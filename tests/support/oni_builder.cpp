// SPDX-License-Identifier: Apache-2.0
#include "tests/support/oni_builder.hpp"

#include <cstring>

namespace g3d::test {
namespace {

template <typename T>
void append(OniBytes& to, T value) {
  std::uint8_t bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  to.insert(to.end(), bytes, bytes + sizeof(T));
}

void append_text(OniBytes& to, std::string_view text) {
  append(to, static_cast<std::uint32_t>(text.size() + 1));
  to.insert(to.end(), text.begin(), text.end());
  to.push_back(0);
}

}  // namespace

OniBuilder::OniBuilder(std::uint32_t highest_node, std::uint64_t last_stamp_us) {
  for (const char c : std::string_view("NI10\x01\x00\x01\x00\x00\x00\x00\x00", 12))
    bytes_.push_back(static_cast<std::uint8_t>(c));
  append(bytes_, last_stamp_us);
  append(bytes_, highest_node);
}

void OniBuilder::record(std::uint32_t node, std::uint32_t type, const OniBytes& fields, const OniBytes& data) {
  append(bytes_, std::uint32_t{0x0052494E});
  append(bytes_, type);
  append(bytes_, node);
  append(bytes_, static_cast<std::uint32_t>(28 + fields.size()));
  append(bytes_, static_cast<std::uint32_t>(data.size()));
  append(bytes_, std::uint64_t{0});
  bytes_.insert(bytes_.end(), fields.begin(), fields.end());
  bytes_.insert(bytes_.end(), data.begin(), data.end());
}

void OniBuilder::node(std::uint32_t id, std::string_view name, std::uint32_t type, std::string_view code,
                      std::uint32_t frames) {
  OniBytes fields;
  append_text(fields, name);
  append(fields, type);
  for (const char c : code) fields.push_back(static_cast<std::uint8_t>(c));
  append(fields, frames);
  append(fields, std::uint64_t{0});
  append(fields, std::uint64_t{1'000'000});
  append(fields, std::uint64_t{0});
  record(id, 0x0D, fields, {});
}

void OniBuilder::property(std::uint32_t node, std::string_view key, const OniBytes& value, std::uint32_t type) {
  OniBytes fields;
  append_text(fields, key);
  append(fields, static_cast<std::uint32_t>(value.size()));
  fields.insert(fields.end(), value.begin(), value.end());
  record(node, type, fields, {});
}

void OniBuilder::int_property(std::uint32_t node, std::string_view key, std::uint64_t value) {
  OniBytes bytes;
  append(bytes, value);
  property(node, key, bytes, 3);
}

void OniBuilder::describe(std::uint32_t node, bool is_depth, std::uint32_t width, std::uint32_t height) {
  OniBytes mode, fov;
  for (const std::uint32_t number : {width, height, 30U}) append(mode, number);
  append(fov, 1.0);
  append(fov, 0.8);
  int_property(node, "oniRequiredFrameSize", std::uint64_t{width} * height * (is_depth ? 2 : 3));
  if (is_depth) int_property(node, "xnDeviceMaxDepth", 10'000);
  property(node, "xnMapOutputMode", mode);
  int_property(node, "oniPixelFormat", is_depth ? 100 : 200);
  property(node, "xnFOV", fov);
  property(node, "xnCropping", OniBytes(12, 0));
  bare(node, 9);
}

void OniBuilder::bare(std::uint32_t node, std::uint32_t type) { record(node, type, {}, {}); }

void OniBuilder::data_begin(std::uint32_t node) { record(node, 8, OniBytes(12, 0xFF), {}); }

void OniBuilder::image(std::uint32_t node, std::uint64_t stamp_us, std::uint32_t number, const OniBytes& data) {
  OniBytes fields;
  append(fields, stamp_us);
  append(fields, number);
  record(node, 0x0A, fields, data);
}

OniBytes flat_depth_code(std::size_t pixels, std::uint16_t mm) {
  OniBytes code;
  append(code, std::uint16_t{2});  // a table of two: none, and this one
  append(code, std::uint16_t{0});
  append(code, mm);
  append(code, std::uint16_t{1});  // the first pixel
  std::size_t left = pixels - 1;
  if (left % 2 == 1) {  // no difference, and no second one
    code.push_back(0x6D);
    --left;
  }
  for (; left > 0; left -= left >= 60 ? 60 : left)
    code.push_back(static_cast<std::uint8_t>(0xE0 + (left >= 60 ? 30 : left / 2)));
  return code;
}

OniBytes flat_rgb(std::size_t pixels, std::uint8_t value) { return OniBytes(3 * pixels, value); }

OniBytes small_oni(std::uint32_t width, std::uint32_t height, std::uint32_t frames) {
  OniBuilder file;
  file.node(1, "Depth1", 2, "16zT", frames);
  file.describe(1, true, width, height);
  file.node(2, "Image1", 3, "NONE", frames);
  file.describe(2, false, width, height);
  file.data_begin(1);
  file.data_begin(2);
  const std::size_t pixels = std::size_t{width} * height;
  for (std::uint32_t i = 1; i <= frames; ++i) {
    file.image(2, 33'333ULL * i, i, flat_rgb(pixels, static_cast<std::uint8_t>(i)));
    file.image(1, 33'333ULL * i + 5000, i, flat_depth_code(pixels, static_cast<std::uint16_t>(1000 + 10 * i)));
  }
  file.bare(1, 7);
  file.bare(2, 7);
  file.bare(2, 0x0B);
  return file.bytes();
}

}  // namespace g3d::test
