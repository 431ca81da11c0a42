// SPDX-License-Identifier: Apache-2.0
#include "net/journal_file.hpp"

#include <catch2/catch.hpp>
#include <cerrno>

#include "hal/disk.hpp"
#include "net/journal_frame.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using mapper::Bytes;
using net::JournalFile;

namespace {

/// Takes so many bytes more, then says that it is full; or loses a bit; or syncs nothing.
struct JournalDisk final : hal::Disk {
  [[nodiscard]] ssize_t write(int fd, const void* data, std::size_t size_bytes) override {
    if (left_bytes == 0) {
      errno = ENOSPC;
      return -1;
    }
    const std::size_t taken = std::min(size_bytes, left_bytes);
    left_bytes -= taken;
    Bytes bytes(static_cast<const std::uint8_t*>(data), static_cast<const std::uint8_t*>(data) + taken);
    if (loses_a_bit) bytes[taken / 2] ^= 4;
    return Disk::write(fd, bytes.data(), taken);
  }
  [[nodiscard]] int fsync(int fd) override {
    if (!syncs) errno = EIO;
    return syncs ? Disk::fsync(fd) : -1;
  }
  std::size_t left_bytes = 1 << 30;
  bool loses_a_bit = false;
  bool syncs = true;
};

int whole_frames(const std::string& path) {
  net::FrameReader reader;
  REQUIRE(reader.open(path).ok());
  int frames = 0;
  while (reader.next().value() == net::FrameReader::Next::frame) ++frames;
  CHECK(reader.good_bytes() == reader.file_bytes());
  return frames;
}

}  // namespace

TEST_CASE("a journal is gone on with behind what is good of it", "[net]") {
  const test::TempFolder folder;
  JournalFile file;
  REQUIRE(file.create(folder / "j").ok());
  REQUIRE(file.append(Bytes(10, 1)).ok());
  const std::uint64_t good_bytes = file.bytes();
  REQUIRE(file.append(Bytes(10, 2)).ok());
  REQUIRE(file.sync().ok());
  file.close();
  CHECK(whole_frames(folder / "j") == 2);
  JournalFile again;
  REQUIRE(again.open(folder / "j", good_bytes).ok());
  REQUIRE(again.append(Bytes(30, 3)).ok());
  REQUIRE(again.append(Bytes(30, 4)).ok());
  CHECK(whole_frames(folder / "j") == 3);
  CHECK(file.open(folder / "none", 0).error().reason == hal::Reason::not_found);
}

TEST_CASE("a full disk leaves a journal that can be read to its end, wherever it becomes full", "[net]") {
  const test::TempFolder folder;
  for (std::size_t room = 0; room < 40; ++room) {
    JournalDisk disk;
    JournalFile file;
    const hal::DiskInstead instead(disk);
    REQUIRE(file.create(folder / "j").ok());
    REQUIRE(file.append(Bytes(10, 1)).ok());
    disk.left_bytes = room;
    const auto full = file.append(Bytes(32, 2));
    REQUIRE_FALSE(full.ok());
    CHECK(full.error().reason == hal::Reason::disk_full);
    CHECK_FALSE(file.is_open());
    CHECK(whole_frames(folder / "j") == 1);
  }
}

TEST_CASE("a new journal takes the old one's place only if the disk gives back what it was given", "[net]") {
  const test::TempFolder folder;
  JournalDisk disk;
  const hal::DiskInstead instead(disk);
  JournalFile old;
  REQUIRE(old.create(folder / "j").ok());
  JournalFile file;
  REQUIRE(file.create(folder / "j.new").ok());
  disk.loses_a_bit = true;
  REQUIRE(file.append(Bytes(100, 1)).ok());
  disk.loses_a_bit = false;
  REQUIRE(file.append(Bytes(100, 2)).ok());
  const auto bad = file.replace(folder / "j");
  REQUIRE_FALSE(bad.ok());
  CHECK(bad.error().reason == hal::Reason::bad_checksum);
  CHECK_FALSE(file.is_at(folder / "j"));
  CHECK(whole_frames(folder / "j") == 0);
  REQUIRE(file.create(folder / "j.new").ok());
  REQUIRE(file.append(Bytes(100, 1)).ok());
  REQUIRE(file.replace(folder / "j").ok());
  CHECK(file.is_at(folder / "j"));
  REQUIRE(file.append(Bytes(100, 2)).ok());
  CHECK(whole_frames(folder / "j") == 2);
  CHECK(folder.listing() == "j\n");
  disk.syncs = false;
  REQUIRE_FALSE(file.sync().ok());
  CHECK_FALSE(file.is_open());
}
