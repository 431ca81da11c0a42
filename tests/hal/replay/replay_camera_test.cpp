// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/replay_camera.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "hal/image/png_writer.hpp"
#include "hal/replay/recorded_poses.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using g3d::test::read_plain;
using g3d::test::TempFolder;
using g3d::test::write_plain;

namespace {

const ImageSize kSize{16, 8};

void write_depth(const std::string& path, std::uint16_t value, ImageSize size = kSize) {
  REQUIRE(write_png_depth(path, size, std::vector<std::uint16_t>(size.pixel_count(), value)).ok());
}

void write_colour(const std::string& path, std::uint8_t value, ImageSize size = kSize) {
  REQUIRE(write_png_rgb(path, size, std::vector<std::uint8_t>(3 * size.pixel_count(), value)).ok());
}

void write_camera(const TempFolder& folder) { write_plain(folder / "camera.txt", "16 16 8 4 1000 16 8\n"); }

}  // namespace

TEST_CASE("A recorded folder is replayed frame by frame") {
  const TempFolder folder;
  write_camera(folder);
  write_plain(folder / "depth.txt", "1.0 depth/1.png\n1.1 depth/2.png\n");
  write_plain(folder / "rgb.txt", "1.01 rgb/1.png\n");
  write_depth(folder / "depth/1.png", 1001);
  write_depth(folder / "depth/2.png", 1002);
  write_colour(folder / "rgb/1.png", 77);
  const auto opened = ReplayCamera::open(folder.path());
  REQUIRE(opened.ok());
  ReplayCamera& camera = *opened.value();
  CHECK(camera.frame_count() == 2U);
  CHECK(camera.model().width_px == 16);
  Frame frame = make_frame(camera.model());

  CHECK(camera.read(frame).event == CameraEvent::frame);
  CHECK(frame.stamp_ns == 1'000'000'000);
  CHECK(frame.sequence == 0);
  CHECK(frame.has_colour);
  CHECK(std::count(frame.depth.get(), frame.depth.get() + 128, 1001) == 128);
  CHECK(std::count(frame.rgb.get(), frame.rgb.get() + 384, 77) == 384);

  CHECK(camera.read(frame).event == CameraEvent::frame);
  CHECK(frame.stamp_ns == 1'100'000'000);
  CHECK(frame.sequence == 1);
  CHECK_FALSE(frame.has_colour);
  CHECK(camera.unmatched_colours() == 1);
  CHECK(frame.depth[0] == 1002);

  CHECK(camera.read(frame).event == CameraEvent::end);
  CHECK(camera.read(frame).event == CameraEvent::end);
  CHECK(camera.broken_colours() == 0);
  CHECK(camera.last_error().empty());
}

TEST_CASE("Every bad depth image is one counted drop, and the next frame comes") {
  const TempFolder folder;
  write_camera(folder);
  write_plain(folder / "depth.txt",
              "1 missing.png\n2 truncated.png\n3 text.png\n4 small.png\n5 colour.png\n5 good.png\n4.5 good.png\n"
              "6 folder\n7 good.png\n");
  write_depth(folder / "good.png", 1500);
  const std::string good = read_plain(folder / "good.png");
  write_plain(folder / "truncated.png", good.substr(0, good.size() - 15));
  write_plain(folder / "text.png", "this is no image");
  write_depth(folder / "small.png", 1500, {15, 8});
  write_colour(folder / "colour.png", 1);
  (void)(folder / "folder/x");
  const auto opened = ReplayCamera::open(folder.path());
  REQUIRE(opened.ok());
  ReplayCamera& camera = *opened.value();
  Frame frame = make_frame(camera.model());
  using enum DropReason;
  const std::vector<std::pair<DropReason, std::string>> expected{
      {unreadable_depth, "missing.png"}, {unreadable_depth, "truncated.png"}, {unreadable_depth, "text.png"},
      {wrong_size, "small.png"},         {unreadable_depth, "colour.png"},    {time_backwards, "good.png"},
      {time_backwards, "good.png"},      {unreadable_depth, "folder"},
  };
  for (const auto& [reason, file] : expected) {
    INFO(file);
    const CameraRead read = camera.read(frame);
    CHECK(read.event == CameraEvent::dropped);
    CHECK(read.reason == reason);
    CHECK(camera.last_error().find(file) != std::string::npos);
  }
  CHECK(camera.read(frame).event == CameraEvent::frame);
  CHECK(frame.sequence == 8);
  CHECK(frame.depth[5] == 1500);
  CHECK(camera.read(frame).event == CameraEvent::end);
}

TEST_CASE("A bad colour image costs the colour, not the frame") {
  const TempFolder folder;
  write_camera(folder);
  write_plain(folder / "depth.txt", "1 d.png\n2 d.png\n3 d.png\n4 d.png\n");
  write_plain(folder / "rgb.txt", "1 missing.jpg\n2 broken.jpg\n3 small.png\n4 good.png\n");
  write_depth(folder / "d.png", 900);
  write_plain(folder / "broken.jpg", "\xFF\xD8\xFF nothing");
  write_colour(folder / "small.png", 5, {8, 8});
  write_colour(folder / "good.png", 6);
  const auto opened = ReplayCamera::open(folder.path());
  REQUIRE(opened.ok());
  ReplayCamera& camera = *opened.value();
  Frame frame = make_frame(camera.model());
  for (int i = 0; i < 3; ++i) {
    CHECK(camera.read(frame).event == CameraEvent::frame);
    CHECK_FALSE(frame.has_colour);
  }
  CHECK(camera.last_error().find("small.png") != std::string::npos);
  CHECK(camera.broken_colours() == 3);
  CHECK(camera.read(frame).event == CameraEvent::frame);
  CHECK(frame.has_colour);
}

TEST_CASE("An empty recording ends at once") {
  const TempFolder folder;
  write_plain(folder / "depth.txt", "# nothing\n");
  const auto opened = ReplayCamera::open(folder.path());
  REQUIRE(opened.ok());
  CHECK(opened.value()->warnings().size() == 2);
  Frame frame = make_frame(opened.value()->model());
  CHECK(opened.value()->read(frame).event == CameraEvent::end);
  CHECK_FALSE(ReplayCamera::open(folder.path() + "/none").ok());
}

TEST_CASE("Real recordings are read whole, with a pose for every frame") {
  const std::string data = g3d::test::data_folder();
  if (data.empty()) {
    WARN("no recordings here: set G3D_DATA to test with them");
    return;
  }
  const std::vector<std::pair<std::string, std::size_t>> recordings{
      {"rgbd_3dmatch_couch_5", 5}, {"rgbd_tum_fr2_pioneer_10", 10}, {"rgbd_tum_fr1_rpy", 150}};
  for (const auto& [name, frames] : recordings) {
    INFO(name);
    const auto camera = ReplayCamera::open(data + "/" + name);
    REQUIRE(camera.ok());
    const auto poses = RecordedPoses::open(data + "/" + name);
    REQUIRE(poses.ok());
    CHECK(camera.value()->warnings().empty());
    CHECK(camera.value()->frame_count() == frames);
    Frame frame = make_frame(camera.value()->model());
    for (std::size_t i = 0; i < std::min<std::size_t>(frames, 20); ++i) {
      REQUIRE(camera.value()->read(frame).event == CameraEvent::frame);
      CHECK(frame.has_colour);
      const std::size_t pixels = camera.value()->model().pixel_count();
      const auto readings = std::count_if(frame.depth.get(), frame.depth.get() + pixels, [](auto d) { return d != 0; });
      CHECK(static_cast<std::size_t>(readings) > pixels / 4);
      Pose pose;
      CHECK(poses.value()->pose_at(frame.stamp_ns, pose) == PoseStatus::ok);
    }
    CHECK(camera.value()->last_error().empty());
  }
}
