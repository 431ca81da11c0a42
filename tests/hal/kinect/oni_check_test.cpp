// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "hal/kinect/oni_check.hpp"
#include "tests/support/oni_builder.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;
using g3d::test::flat_depth_code;
using g3d::test::flat_rgb;
using g3d::test::OniBuilder;
using g3d::test::OniBytes;
using g3d::test::small_oni;

namespace {

constexpr std::size_t kOniPixels = 32 * 16;

/// One depth image; `change` may spoil the file before its end is written.
template <typename Describe, typename Images>
OniBytes oni_of(const Describe& describe, const Images& images) {
  OniBuilder file;
  file.node(1, "Depth1", 2, "16zT", 1);
  describe(file);
  file.data_begin(1);
  images(file);
  file.bare(1, 0x0B);
  return file.bytes();
}
void good_node(OniBuilder& file) { file.describe(1, true, 32, 16); }
void good_image(OniBuilder& file) { file.image(1, 1000, 1, flat_depth_code(kOniPixels, 900)); }

Reason reason_of(const OniBytes& bytes) {
  const auto checked = check_oni(bytes, "a.oni");
  REQUIRE_FALSE(checked.ok());
  CHECK_THAT(checked.error().text, Catch::StartsWith("a.oni: byte "));
  return checked.error().reason;
}

}  // namespace

TEST_CASE("a good .oni file is described") {
  const auto checked = check_oni(small_oni(32, 16, 3), "a.oni");
  REQUIRE(checked.ok());
  CHECK(checked.value().depth.width_px == 32);
  CHECK(checked.value().depth.height_px == 16);
  CHECK(checked.value().depth.frames == 3);
  CHECK(checked.value().colour.frames == 3);
  CHECK(checked.value().depth.horizontal_fov_rad == 1.0);
  CHECK_FALSE(checked.value().depth.is_mirrored);
  CHECK(check_oni(oni_of(good_node, good_image), "a.oni").ok());
}

TEST_CASE("an .oni file that is cut anywhere is said to be cut, with the byte") {
  const OniBytes whole = small_oni(32, 16, 2);
  for (std::size_t bytes = 0; bytes < whole.size(); bytes += bytes < 1500 ? 1 : 97) {
    INFO(bytes);
    const auto checked = check_oni(std::span(whole).first(bytes), "a.oni");
    REQUIRE_FALSE(checked.ok());
    CHECK(checked.error().reason == Reason::truncated);
    CHECK_THAT(checked.error().text, Catch::Contains("cut off"));
  }
}

TEST_CASE("what OpenNI2's player would stumble over is refused before it sees it") {
  const auto nothing = [](OniBuilder&) {};
  CHECK(reason_of(oni_of(good_node, nothing)) == Reason::malformed);
  const auto image_of = [&](std::uint64_t stamp_us, std::uint32_t number, const OniBytes& code) {
    return oni_of(good_node, [&](OniBuilder& file) { file.image(1, stamp_us, number, code); });
  };
  const OniBytes code = flat_depth_code(kOniPixels, 900);
  CHECK(check_oni(image_of(1, 1, code), "a.oni").ok());
  CHECK(reason_of(image_of(2'000'000, 1, code)) == Reason::malformed);
  CHECK(reason_of(image_of(1, 0, code)) == Reason::malformed);
  CHECK(reason_of(image_of(1, 2, code)) == Reason::malformed);
  CHECK(reason_of(image_of(1, 1, flat_depth_code(kOniPixels + 2, 900))) == Reason::malformed);
  CHECK(reason_of(image_of(1, 1, {})) == Reason::malformed);
  const auto node_of = [&](const auto& describe) { return reason_of(oni_of(describe, good_image)); };
  CHECK(node_of([](OniBuilder& file) { file.bare(1, 9); }) == Reason::malformed);
  CHECK(node_of([](OniBuilder& file) { file.describe(1, true, 2000, 16); }) == Reason::out_of_range);
  CHECK(node_of([](OniBuilder& file) { file.property(1, "xnMapOutputMode", OniBytes(11)); }) == Reason::malformed);
  CHECK(node_of([](OniBuilder& file) { file.property(1, "xnCropping", OniBytes(12, 1)); }) == Reason::unsupported);
  CHECK(node_of([](OniBuilder& file) { file.property(1, "x", OniBytes(7), 3); }) == Reason::malformed);
  CHECK(node_of([](OniBuilder& file) { file.property(1, "x", OniBytes{'a'}, 5); }) == Reason::malformed);
  CHECK(node_of([](OniBuilder& file) { file.int_property(1, "oniRequiredFrameSize", 1U << 31); }) == Reason::too_large);
  CHECK(node_of([](OniBuilder& file) { file.int_property(1, "xnDeviceMaxDepth", 70'000); }) == Reason::out_of_range);
  CHECK(node_of([](OniBuilder& file) { file.int_property(1, "oniPixelFormat", 101); }) == Reason::unsupported);
  CHECK(node_of([](OniBuilder& file) { file.int_property(9, "x", 1); }) == Reason::malformed);
  CHECK(node_of([](OniBuilder& file) { file.int_property(2, "x", 1); }) == Reason::malformed);
  CHECK(node_of([](OniBuilder& file) { file.node(1, "again", 2, "16zT", 1); }) == Reason::malformed);
  CHECK(node_of([](OniBuilder& file) { file.node(2, "Depth2", 2, "16zT", 1); }) == Reason::unsupported);
  CHECK(node_of([](OniBuilder& file) { file.node(2, "Image1", 3, "Im8z", 1); }) == Reason::unsupported);
  CHECK(node_of([](OniBuilder& file) {
          file.describe(1, true, 32, 16);
          file.bare(1, 7);
        }) == Reason::malformed);
  CHECK(node_of([](OniBuilder& file) {
          file.describe(1, true, 32, 16);
          file.bare(1, 0x44);
        }) == Reason::unsupported);
}

TEST_CASE("other versions and many nodes are refused, and files that are none") {
  OniBytes bytes = small_oni(32, 16, 1);
  bytes[5] = 9;
  CHECK(reason_of(bytes) == Reason::unsupported);
  bytes = small_oni(32, 16, 1);
  bytes[0] = 'X';
  CHECK(reason_of(bytes) == Reason::malformed);
  bytes = small_oni(32, 16, 1);
  bytes[22] = 1;
  CHECK(reason_of(bytes) == Reason::malformed);
  const g3d::test::TempFolder folder;
  CHECK(check_oni_file(folder / "none.oni").error().reason == Reason::not_found);
  CHECK_FALSE(check_oni_file(folder.path()).ok());
  g3d::test::write_plain(folder / "empty.oni", "");
  CHECK(check_oni_file(folder / "empty.oni").error().reason == Reason::truncated);
  g3d::test::write_plain(folder / "good.oni", std::span<const std::uint8_t>(small_oni(32, 16, 1)));
  CHECK(check_oni_file(folder / "good.oni").ok());
  CHECK(check_oni_file("/" + std::string(300, 'a')).error().reason == Reason::unsupported);
}

TEST_CASE("flipped bits in an .oni file never do harm") {
  const OniBytes good = small_oni(32, 16, 2);
  std::mt19937 random(7);
  std::size_t refused = 0;
  for (int run = 0; run < 3000; ++run) {
    OniBytes bytes = good;
    for (unsigned i = 0; i <= random() % 3; ++i) {
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1U << (random() % 8));
    }
    refused += check_oni(bytes, "a.oni").ok() ? 0 : 1;
  }
  CHECK(refused > 300);
}
