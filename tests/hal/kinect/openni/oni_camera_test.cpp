// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/oni_camera.hpp"

#include <sodium.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "hal/frame_pool.hpp"
#include "tests/support/oni_builder.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;
using namespace g3d::hal::kinect::openni;
using g3d::test::small_oni;
using g3d::test::TempFolder;
using g3d::test::write_plain;

namespace {

std::string sha256(const void* data, std::size_t bytes) {
  unsigned char digest[crypto_hash_sha256_BYTES];
  crypto_hash_sha256(digest, static_cast<const unsigned char*>(data), bytes);
  char text[2 * sizeof digest + 1];
  sodium_bin2hex(text, sizeof text, digest, sizeof digest);
  return text;
}

struct ReferenceImage {
  std::string kind;
  int number = 0;
  std::int64_t stamp_us = 0;
  std::string digest;
};

std::vector<ReferenceImage> read_reference(const std::string& path) {
  std::vector<ReferenceImage> images;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    ReferenceImage image;
    std::string min, max, valid;
    words >> image.kind >> image.number >> image.stamp_us >> min >> max >> valid >> image.digest;
    images.push_back(image);
  }
  return images;
}

std::string recording_folder() {
  const std::string data = g3d::test::data_folder();
  if (data.empty() || !std::ifstream(data + "/oni/kinect360_12frames.oni")) return {};
  return data + "/oni/";
}

}  // namespace

TEST_CASE("an .oni file is played image by image, whole and in order, with its own stamps") {
  const TempFolder folder;
  write_plain(folder / "a.oni", std::span<const std::uint8_t>(small_oni(64, 48, 9)));
  for (int round = 0; round < 2; ++round) {
    auto camera = open_oni_camera(folder / "a.oni", {});
    if (!camera) FAIL(camera.error().text);
    CHECK(camera.value()->frame_count() == 9U);
    CHECK(camera.value()->model().width_px == 64);
    Frame frame = make_frame(camera.value()->model());
    for (int i = 1; i <= 9; ++i) {
      REQUIRE(camera.value()->read(frame).event == CameraEvent::frame);
      CHECK(frame.sequence == static_cast<std::uint64_t>(i));
      CHECK(frame.stamp_ns == (33'333LL * i + 5000) * 1000);
      CHECK(frame.depth[0] == 1000 + 10 * i);
      CHECK(frame.depth[64 * 48 - 1] == 1000 + 10 * i);
      REQUIRE(frame.has_colour);
      CHECK(frame.rgb[3 * 64 * 48 - 1] == i);
    }
    CHECK(camera.value()->read(frame).event == CameraEvent::end);
    CHECK(camera.value()->read(frame).event == CameraEvent::end);
    CHECK(camera.value()->last_error().empty());
  }
}

TEST_CASE("a recording of a calibrated Kinect is corrected") {
  const TempFolder folder;
  write_plain(folder / "a.oni", std::span<const std::uint8_t>(small_oni(64, 48, 1)));
  OniCameraOptions options;
  options.has_calibration = true;
  options.calibration.depth_offset_m = 0.1;
  options.calibration.colour.fx_px = 500.0;
  auto camera = open_oni_camera(folder / "a.oni", options);
  if (!camera) FAIL(camera.error().text);
  CHECK(camera.value()->model().fx_px == Approx(50.0));
  Frame frame = make_frame(camera.value()->model());
  REQUIRE(camera.value()->read(frame).event == CameraEvent::frame);
  CHECK(frame.depth[0] == 1110);
}

TEST_CASE("what is no good recording is refused before it is played") {
  const TempFolder folder;
  CHECK(open_oni_camera(folder / "none.oni", {}).error().reason == Reason::not_found);
  const auto good = small_oni(64, 48, 4);
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{10}, good.size() / 3, good.size() - 1}) {
    write_plain(folder / "cut.oni", std::span<const std::uint8_t>(good).first(bytes));
    CHECK(open_oni_camera(folder / "cut.oni", {}).error().reason == Reason::truncated);
  }
}

TEST_CASE("flipped bits are refused, or played to the end", "[slow]") {
  const TempFolder folder;
  const auto good = small_oni(64, 48, 3);
  std::mt19937 random(11);
  int played = 0;
  for (int run = 0; run < 150; ++run) {
    auto bad = good;
    for (unsigned i = 0; i <= random() % 3; ++i) {
      bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1U << (random() % 8));
    }
    write_plain(folder / "bad.oni", std::span<const std::uint8_t>(bad));
    auto camera = open_oni_camera(folder / "bad.oni", {});
    if (!camera) continue;
    ++played;
    Frame frame = make_frame(camera.value()->model());
    for (int i = 0; i < 10 && camera.value()->read(frame).event != CameraEvent::end; ++i) {
    }
  }
  CHECK(played > 10);
}

TEST_CASE("all 24 images of a real Kinect's recording are those of the reference") {
  const std::string folder = recording_folder();
  if (folder.empty()) {
    WARN("no recordings here: set G3D_DATA to test with them");
    return;
  }
  const std::vector<ReferenceImage> reference = read_reference(folder + "frames.txt");
  REQUIRE(reference.size() == 24);
  OniCameraOptions options;
  options.keeps_mirrored = true;
  auto camera = open_oni_camera(folder + "kinect360_12frames.oni", options);
  if (!camera) FAIL(camera.error().text);
  CHECK(camera.value()->model().fx_px == Approx(320.0 / std::tan(0.5 * 1.014469)).epsilon(1e-5));
  Frame frame = make_frame(camera.value()->model());
  const std::size_t pixels = camera.value()->model().pixel_count();
  for (std::size_t i = 0; i < 12; ++i) {
    REQUIRE(camera.value()->read(frame).event == CameraEvent::frame);
    REQUIRE(frame.has_colour);
    CHECK(frame.stamp_ns == 1000 * reference[i].stamp_us);
    CHECK(sha256(frame.depth.get(), 2 * pixels) == reference[i].digest);
    CHECK(sha256(frame.rgb.get(), 3 * pixels) == reference[12 + i].digest);
  }
  CHECK(camera.value()->read(frame).event == CameraEvent::end);
}

TEST_CASE("a mirrored recording is turned round, depth and colour alike") {
  const std::string folder = recording_folder();
  if (folder.empty()) return;
  Frame recorded, turned;
  for (const bool keeps : {true, false}) {
    OniCameraOptions options;
    options.keeps_mirrored = keeps;
    auto camera = open_oni_camera(folder + "kinect360_12frames.oni", options);
    REQUIRE(camera.ok());
    Frame& frame = keeps ? recorded : turned;
    frame = make_frame(camera.value()->model());
    REQUIRE(camera.value()->read(frame).event == CameraEvent::frame);
  }
  std::size_t differences = 0;
  for (std::size_t v = 0; v < 480; ++v) {
    for (std::size_t u = 0; u < 640; ++u) {
      const std::size_t a = v * 640 + u, b = v * 640 + 639 - u;
      differences += recorded.depth[a] != turned.depth[b];
      differences += recorded.rgb[3 * a + 1] != turned.rgb[3 * b + 1];
    }
  }
  CHECK(differences == 0);
}

TEST_CASE("a real recording that is cut anywhere is said to be cut") {
  const std::string folder = recording_folder();
  if (folder.empty()) return;
  const std::string whole = g3d::test::read_plain(folder + "kinect360_12frames.oni");
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(whole.data());
  for (std::size_t cut = 1; cut < whole.size(); cut += whole.size() / 37) {
    const auto checked = check_oni({bytes, cut}, "cut.oni");
    REQUIRE_FALSE(checked.ok());
    CHECK(checked.error().reason == Reason::truncated);
  }
  CHECK(check_oni({bytes, whole.size()}, "whole.oni").ok());
}
