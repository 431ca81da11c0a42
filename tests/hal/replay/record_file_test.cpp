// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/record_file.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <string>
#include <string_view>

#include "hal/disk.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::Reason;
using hal::RecordFile;

namespace {

bool append_text(RecordFile& file, std::string_view text) {
  return file.append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace

TEST_CASE("a file of records holds them one after another, and nothing of what was there before") {
  const test::TempFolder folder;
  test::write_plain(folder / "log", "a much longer text than what follows");
  auto file = RecordFile::create(folder / "log");
  REQUIRE(file.ok());
  CHECK(file.value().path() == folder / "log");
  CHECK(append_text(file.value(), "first "));
  CHECK(append_text(file.value(), ""));
  RecordFile moved = std::move(file).value();
  CHECK(append_text(moved, "second"));
  CHECK(moved.close().ok());
  CHECK(moved.close().ok());  // changes nothing
  CHECK(test::read_plain(folder / "log") == "first second");
}

TEST_CASE("a file of records has one writer") {
  const test::TempFolder folder;
  {
    auto file = RecordFile::create(folder / "log");
    REQUIRE(file.ok());
    CHECK(append_text(file.value(), "kept"));
    const auto second = RecordFile::create(folder / "log");
    REQUIRE_FALSE(second.ok());
    CHECK(second.error().reason == Reason::no_permission);
    CHECK(second.error().text.find("another robot") != std::string::npos);
    CHECK(test::read_plain(folder / "log") == "kept");
  }
  CHECK(RecordFile::create(folder / "log").ok());
  const auto nowhere = RecordFile::create(folder.path() + "/no/such/log");
  REQUIRE_FALSE(nowhere.ok());
  CHECK(nowhere.error().reason == Reason::not_found);
  CHECK(nowhere.error().text.find("no/such/log") != std::string::npos);
}

TEST_CASE("of a record that a disk takes half nothing stays, once it takes records again") {
  struct HalfADisk final : hal::Disk {
    ssize_t write(int fd, const void* data, std::size_t size_bytes) override {
      if (room_bytes == 0) errno = ENOSPC;
      if (room_bytes == 0) return -1;
      const std::size_t taken = std::min(room_bytes, size_bytes);
      room_bytes -= taken;
      return Disk::write(fd, data, taken);
    }
    int ftruncate(int fd, off_t size) override {
      if (cuts) return Disk::ftruncate(fd, size);
      errno = EIO;
      return -1;
    }
    std::size_t room_bytes = 6;
    bool cuts = true;
  } disk;
  const test::TempFolder folder;
  const hal::DiskInstead instead(disk);
  auto made = RecordFile::create(folder / "log");
  REQUIRE(made.ok());
  RecordFile& file = made.value();
  CHECK(append_text(file, "1234"));
  CHECK_FALSE(append_text(file, "5678"));
  CHECK(test::read_plain(folder / "log") == "123456");
  // While the half cannot be taken away nothing may follow it.
  disk.room_bytes = 100;
  disk.cuts = false;
  CHECK_FALSE(append_text(file, "9abc"));
  disk.cuts = true;
  CHECK(append_text(file, "defg"));
  CHECK(test::read_plain(folder / "log") == "1234defg");
  const auto closed = file.close();
  REQUIRE_FALSE(closed.ok());
  CHECK(closed.error().reason == Reason::disk_full);
}
