// SPDX-License-Identifier: Apache-2.0
#include "hal/record/append_file.hpp"

#include <catch2/catch.hpp>
#include <cerrno>
#include <string>

#include "hal/disk.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::AppendFile;

namespace {

/// Full after so many bytes.
class SmallDisk final : public hal::Disk {
 public:
  [[nodiscard]] ssize_t write(int fd, const void* data, std::size_t size_bytes) override {
    if (room_bytes == 0) {
      errno = ENOSPC;
      return -1;
    }
    const std::size_t some = std::min(size_bytes, room_bytes);
    room_bytes -= some;
    return Disk::write(fd, data, some);
  }
  [[nodiscard]] int ftruncate(int fd, off_t size_bytes) override {
    return refuses_to_cut ? (errno = EIO, -1) : Disk::ftruncate(fd, size_bytes);
  }
  std::size_t room_bytes = 1000;
  bool refuses_to_cut = false;
};

}  // namespace

TEST_CASE("lines are in the file as soon as they are appended") {
  const test::TempFolder folder;
  auto file = AppendFile::create(folder / "list.txt");
  REQUIRE(file.ok());
  CHECK(file.value().append("one\n") == 0);
  CHECK(test::read_plain(folder / "list.txt") == "one\n");
  CHECK(file.value().append("two\n") == 0);
  CHECK(test::read_plain(folder / "list.txt") == "one\ntwo\n");
  CHECK(file.value().bytes() == 8);
}

TEST_CASE("a line that the disk takes half of is not in the file, and the next one follows whole") {
  const test::TempFolder folder;
  SmallDisk disk;
  const hal::DiskInstead instead(disk);
  auto file = AppendFile::create(folder / "list.txt");
  REQUIRE(file.ok());
  CHECK(file.value().append("one\n") == 0);
  disk.room_bytes = 2;
  CHECK(file.value().append("two\n") == ENOSPC);
  CHECK(test::read_plain(folder / "list.txt") == "one\n");
  disk.room_bytes = 1000;
  CHECK(file.value().append("three\n") == 0);
  CHECK(test::read_plain(folder / "list.txt") == "one\nthree\n");
}

TEST_CASE("behind half a line that cannot be cut off nothing follows until it can") {
  const test::TempFolder folder;
  SmallDisk disk;
  const hal::DiskInstead instead(disk);
  auto file = AppendFile::create(folder / "list.txt");
  REQUIRE(file.ok());
  disk.room_bytes = 2;
  disk.refuses_to_cut = true;
  CHECK(file.value().append("one\n") == ENOSPC);
  disk.room_bytes = 1000;
  CHECK(file.value().append("two\n") == EIO);
  disk.refuses_to_cut = false;
  CHECK(file.value().append("three\n") == 0);
  CHECK(test::read_plain(folder / "list.txt") == "three\n");
}

TEST_CASE("a file that grows has one writer, who begins with nothing") {
  const test::TempFolder folder;
  test::write_plain(folder / "list.txt", "what was there before");
  {
    auto file = AppendFile::create(folder / "list.txt");
    REQUIRE(file.ok());
    CHECK(file.value().append("kept\n") == 0);
    const auto second = AppendFile::create(folder / "list.txt");
    REQUIRE_FALSE(second.ok());
    CHECK(second.error().reason == hal::Reason::no_permission);
    CHECK(second.error().text.find("another robot") != std::string::npos);
    CHECK(test::read_plain(folder / "list.txt") == "kept\n");
    CHECK(file.value().close() == 0);
    CHECK(file.value().append("too late\n") == EBADF);
    CHECK(AppendFile::create(folder / "list.txt").ok());
  }
  CHECK(AppendFile::create(folder / "list.txt").ok());
}

TEST_CASE("a file that cannot be made is named") {
  const auto file = AppendFile::create("/no/such/list.txt");
  REQUIRE_FALSE(file.ok());
  CHECK(file.error().text.find("/no/such/list.txt") == 0);
}
