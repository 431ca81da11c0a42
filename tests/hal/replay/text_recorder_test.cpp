// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/text_recorder.hpp"

#include <catch2/catch.hpp>
#include <cerrno>

#include "hal/disk.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;

namespace {

/// Takes so many bytes, then has no space until somebody makes some.
class FullDisk final : public Disk {
 public:
  ssize_t write(int fd, const void* data, std::size_t size_bytes) override {
    if (room.load() == 0) {
      errno = ENOSPC;
      return -1;
    }
    const std::size_t part = std::min(size_bytes, room.load());
    room -= part;
    return Disk::write(fd, data, part);
  }
  std::atomic<std::size_t> room{13};
};

}  // namespace

TEST_CASE("Lines of a recording come in order and whole", "[threads]") {
  const test::TempFolder folder;
  auto recorder = TextRecorder::create(folder / "a.log");
  REQUIRE(recorder.ok());
  std::string all;
  for (int i = 0; i < 2'000; ++i) {
    const std::string line = "line " + std::to_string(i) + "\n";
    recorder.value()->put(line);
    all += line;
  }
  REQUIRE(recorder.value()->finish().ok());
  CHECK(test::read_plain(folder / "a.log") == all);
  CHECK(recorder.value()->lost_lines() == 0);
}

TEST_CASE("A line that is no line is lost and counted", "[threads]") {
  const test::TempFolder folder;
  auto recorder = TextRecorder::create(folder / "a.log");
  REQUIRE(recorder.ok());
  recorder.value()->put(std::string(TextRecorder::kMaxLine_bytes + 1, 'x'));
  recorder.value()->put("");
  recorder.value()->put("good\n");
  REQUIRE(recorder.value()->finish().ok());
  CHECK(recorder.value()->lost_lines() == 2);
  CHECK(test::read_plain(folder / "a.log") == "good\n");
}

TEST_CASE("A full disk costs lines, and what follows is whole again", "[threads]") {
  const test::TempFolder folder;
  FullDisk disk;
  const DiskInstead instead(disk);
  auto recorder = TextRecorder::create(folder / "a.log");
  REQUIRE(recorder.ok());
  recorder.value()->put("123456789\n");
  recorder.value()->put("abcdefghi\n");  // three bytes of it fit
  while (recorder.value()->lost_lines() == 0) std::this_thread::yield();
  disk.room.store(100);
  recorder.value()->put("ABC\n");
  const auto finished = recorder.value()->finish();
  REQUIRE_FALSE(finished.ok());
  CHECK(finished.error().reason == Reason::disk_full);
  CHECK(recorder.value()->lost_lines() == 1);
  CHECK(test::read_plain(folder / "a.log") == "123456789\nABC\n");
}

TEST_CASE("A recording without a folder is refused", "[threads]") {
  const auto recorder = TextRecorder::create("/nonexistent/a.log");
  REQUIRE_FALSE(recorder.ok());
  CHECK(recorder.error().reason == Reason::not_found);
}
