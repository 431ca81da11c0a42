// SPDX-License-Identifier: Apache-2.0
#include "hal/disk.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>

#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using g3d::test::read_plain;
using g3d::test::TempFolder;

TEST_CASE("the real disk does what the system calls do") {
  const TempFolder folder;
  const std::string path = folder / "a";
  const int fd = disk().open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  REQUIRE(fd >= 0);
  CHECK(disk().write(fd, "abcdef", 6) == 6);
  CHECK(disk().pwrite(fd, "X", 1, 2) == 1);
  std::array<char, 3> read{};
  CHECK(disk().pread(fd, read.data(), read.size(), 1) == 3);
  CHECK(std::string(read.data(), read.size()) == "bXd");
  CHECK(disk().ftruncate(fd, 4) == 0);
  CHECK(disk().fsync(fd) == 0);
  ::close(fd);
  CHECK(disk().rename(path.c_str(), (folder / "b").c_str()) == 0);
  CHECK(read_plain(folder / "b") == "abXd");
  CHECK(disk().open(path.c_str(), O_RDONLY | O_CLOEXEC, 0) == -1);
  CHECK(errno == ENOENT);
}

TEST_CASE("another disk takes its place for a while") {
  class Counting final : public Disk {
   public:
    int fsync(int) override { return ++syncs; }
    int syncs = 0;
  } other;
  {
    const DiskInstead instead(other);
    CHECK(&disk() == &other);
    CHECK(disk().fsync(-1) == 1);
  }
  CHECK(&disk() != &other);
  CHECK(disk().fsync(-1) == -1);
  CHECK(other.syncs == 1);
}
