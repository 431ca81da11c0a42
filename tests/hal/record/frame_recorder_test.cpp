// SPDX-License-Identifier: Apache-2.0
#include "hal/record/frame_recorder.hpp"

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <functional>
#include <mutex>
#include <thread>

#include "hal/disk.hpp"
#include "hal/replay/recording.hpp"
#include "hal/replay/replay_camera.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;

namespace {

CameraModel recorded_camera() {
  CameraModel camera;
  camera.width_px = 24;
  camera.height_px = 16;
  camera.fx_px = 19.7F;
  camera.cx_px = 11.5F;
  camera.cy_px = 7.1F;
  return camera;
}

Frame recorded_frame(int number, bool has_colour = true) {
  const CameraModel camera = recorded_camera();
  Frame frame = make_frame(camera);
  frame.stamp_ns = 1'000'000'007 * TimeNs{number + 1};
  frame.has_colour = has_colour;
  for (std::size_t i = 0; i < camera.pixel_count(); ++i) frame.depth[i] = static_cast<std::uint16_t>(i * 3 + number);
  for (std::size_t i = 0; i < 3 * camera.pixel_count(); ++i) frame.rgb[i] = static_cast<std::uint8_t>(i + number);
  return frame;
}

MappedNote note_of(const Frame& frame) {
  MappedNote note;
  note.stamp_ns = frame.stamp_ns;
  note.T_world_camera = from_xyz_rpy(0.1 + 1e-9 * static_cast<double>(frame.stamp_ns), 1.0 / 3.0, 0.5, 0.1, 0.2, 0.3);
  return note;
}

std::unique_ptr<FrameRecorder> recorder_in(const test::TempFolder& folder, bool with_colour = true) {
  auto recorder = FrameRecorder::create(folder.path(), recorded_camera(), with_colour);
  REQUIRE(recorder.ok());
  return std::move(recorder).value();
}

/// Refuses, or does not answer, as it is told.
class TestDisk final : public Disk {
 public:
  [[nodiscard]] ssize_t write(int fd, const void* data, std::size_t size_bytes) override {
    const std::lock_guard wait(gate);
    if (is_full.load()) {
      errno = ENOSPC;
      return -1;
    }
    return Disk::write(fd, data, size_bytes);
  }
  std::mutex gate;
  std::atomic<bool> is_full{false};
};

bool comes_true(const std::function<bool()>& condition) {
  for (int i = 0; i < 3000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

}  // namespace

TEST_CASE("what was recorded is replayed bit by bit: camera, frames, poses and what the map began with", "[threads]") {
  const test::TempFolder folder;
  auto recorder = recorder_in(folder);
  for (int i = 0; i < 5; ++i) {
    const Frame frame = recorded_frame(i, i != 3);
    recorder->put_frame(frame);
    if (i == 1) continue;  // delivered, and not mapped
    MappedNote note = note_of(frame);
    if (i == 0) note.footprint = {0.1, -0.2, 0.0, 0.18, 0.6};
    Frame masked = recorded_frame(i);
    masked.depth[7] = 1;
    recorder->put_mapped(note, i == 4 ? &masked : nullptr);
  }
  REQUIRE(recorder->finish().ok());
  REQUIRE(recorder->note("map " + std::string(64, 'a')).ok());
  const RecordCounts counts = recorder->counts();
  CHECK(counts.delivered == 5);
  CHECK(counts.written == 5);
  CHECK(counts.poses == 4);
  CHECK(counts.masked == 1);
  CHECK(counts.lost_behind + counts.lost_disk + counts.lost_poses + counts.lost_colours == 0);
  CHECK(counts.bytes > 0);

  auto camera = ReplayCamera::open(folder.path());
  REQUIRE(camera.ok());
  CHECK(camera.value()->model() == recorded_camera());
  const auto log = parse_mapped_log(test::read_plain(folder / "mapped.txt"), "mapped.txt");
  REQUIRE(log.ok());
  REQUIRE(log.value().footprint.has_value());
  CHECK(log.value().footprint->at_m == std::array{0.1, -0.2, 0.0});
  CHECK(log.value().hash == std::string(64, 'a'));
  const ExactPoses poses(read_trajectory(folder / "trajectory.tum").value());
  CHECK(poses.count() == 4);
  MaskedCamera as_mapped(*camera.value(), folder.path(), log.value().masked);
  Frame got = make_frame(recorded_camera());
  for (int i = 0; i < 5; ++i) {
    INFO(i);
    REQUIRE(as_mapped.read(got).event == CameraEvent::frame);
    const Frame was = recorded_frame(i);
    CHECK(got.stamp_ns == was.stamp_ns);
    CHECK(got.has_colour == (i != 3));
    CHECK(got.depth[7] == (i == 4 ? 1 : was.depth[7]));
    CHECK(std::equal(got.depth.get() + 8, got.depth.get() + 24 * 16, was.depth.get() + 8));
    if (got.has_colour) CHECK(std::equal(got.rgb.get(), got.rgb.get() + 3 * 24 * 16, was.rgb.get()));
    Pose pose;
    CHECK((poses.pose_at(got.stamp_ns, pose) == PoseStatus::ok) == (i != 1));
    if (i == 1) continue;
    CHECK(pose.translation_m == note_of(was).T_world_camera.translation_m);
    CHECK(pose.rotation_xyzw == note_of(was).T_world_camera.rotation_xyzw);
  }
  CHECK(as_mapped.read(got).event == CameraEvent::end);
}

TEST_CASE("a disk that does not answer costs frames, which are counted, and nobody waits for it", "[threads]") {
  const test::TempFolder folder;
  TestDisk disk;
  const DiskInstead instead(disk);
  auto recorder = recorder_in(folder);
  const Frame frame = recorded_frame(0);
  {
    const std::lock_guard stuck(disk.gate);
    for (int i = 0; i < 100; ++i) recorder->put_frame(frame);
    const RecordCounts counts = recorder->counts();
    CHECK(counts.delivered == 100);
    CHECK(counts.lost_behind >= 100 - 64 - 1);
    CHECK(counts.lost_behind < 100);
  }
  REQUIRE(recorder->finish().ok());
  const RecordCounts counts = recorder->counts();
  CHECK(counts.written + counts.lost_behind == 100);
}

TEST_CASE("a full disk costs what it refuses, is named, and what comes when it has room again is there", "[threads]") {
  const test::TempFolder folder;
  TestDisk disk;
  const DiskInstead instead(disk);
  auto recorder = recorder_in(folder);
  const auto put = [&](int i) {
    recorder->put_frame(recorded_frame(i));
    recorder->put_mapped(note_of(recorded_frame(i)), nullptr);
  };
  put(0);
  REQUIRE(comes_true([&] { return recorder->counts().written == 1 && recorder->counts().poses == 1; }));
  disk.is_full.store(true);
  put(1);
  put(2);
  REQUIRE(comes_true([&] { return recorder->counts().lost_disk == 2 && recorder->counts().lost_poses == 2; }));
  disk.is_full.store(false);
  put(3);
  const auto finished = recorder->finish();
  REQUIRE_FALSE(finished.ok());
  CHECK(finished.error().reason == Reason::disk_full);
  CHECK(finished.error().text.find(folder.path()) == 0);
  CHECK(recorder->counts().written == 2);
  CHECK(recorder->counts().lost_colours == 0);  // those of lost frames are not counted twice
  auto camera = ReplayCamera::open(folder.path());
  REQUIRE(camera.ok());
  CHECK(camera.value()->frame_count() == 2);
  Frame got = make_frame(recorded_camera());
  CHECK(camera.value()->read(got).event == CameraEvent::frame);
  CHECK(camera.value()->read(got).event == CameraEvent::frame);
  CHECK(got.stamp_ns == recorded_frame(3).stamp_ns);
  CHECK(read_trajectory(folder / "trajectory.tum").value().size() == 2);
}

TEST_CASE("a recording without colour says so", "[threads]") {
  const test::TempFolder folder;
  auto recorder = recorder_in(folder, false);
  recorder->put_frame(recorded_frame(0));
  REQUIRE(recorder->finish().ok());
  CHECK(test::read_plain(folder / "mapped.txt") == "colour no\n");
  CHECK(test::read_plain(folder / "rgb.txt").empty());
}

TEST_CASE("a folder that is not there is named before anything runs") {
  const auto recorder = FrameRecorder::create("/no/such/folder", recorded_camera(), true);
  REQUIRE_FALSE(recorder.ok());
  CHECK(recorder.error().text.find("/no/such/folder") == 0);
}
