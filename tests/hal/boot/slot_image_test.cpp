// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/slot_image.hpp"

#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <vector>

#include "hal/disk.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;
using test::TempFolder;

namespace {

std::vector<std::uint8_t> image_bytes(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 31 + i / 1000);
  return bytes;
}

SlotImageId identity_of(const std::vector<std::uint8_t>& bytes) {
  SlotImageId id{1, bytes.size(), {}};
  crypto_generichash(id.digest.data(), id.digest.size(), bytes.data(), bytes.size(), nullptr, 0);
  return id;
}

}  // namespace

TEST_CASE("a slot's image is written in pieces, read back and recognised", "[slots]") {
  const TempFolder folder;
  const std::string path = folder / "b.img";
  const auto bytes = image_bytes(3'000'001);
  {
    auto image = SlotImage::open_for_writing(path);
    REQUIRE(image.ok());
    REQUIRE(image.value().make_room(bytes.size()).ok());
    struct stat status {};
    REQUIRE(::stat(path.c_str(), &status) == 0);
    CHECK(static_cast<std::size_t>(status.st_size) == bytes.size());
    CHECK((status.st_mode & 0777) == 0600);
    const std::span all(bytes);
    REQUIRE(image.value().write(1'000'000, all.subspan(1'000'000)).ok());
    REQUIRE(image.value().write(0, all.first(1'000'000)).ok());
    REQUIRE(image.value().sync().ok());
    std::vector<std::uint8_t> back(1000);
    REQUIRE(image.value().read(999'500, back).ok());
    CHECK(std::equal(back.begin(), back.end(), bytes.begin() + 999'500));
    CHECK(image.value().read(bytes.size() - 999, back).error().reason == Reason::truncated);
  }
  int calls = 0;
  CHECK(check_slot_image(path, identity_of(bytes), [&calls] { ++calls; }).ok());
  CHECK(calls == 3);
  CHECK(check_slot_image(path, {}).ok());

  auto changed = bytes;
  changed[1'234'567] ^= 1U;
  test::write_plain(path, changed);
  CHECK(check_slot_image(path, identity_of(bytes)).error().reason == Reason::bad_checksum);
  test::write_plain(path, std::span(bytes).first(bytes.size() - 1));
  CHECK(check_slot_image(path, identity_of(bytes)).error().reason == Reason::truncated);
}

TEST_CASE("what is no place for an image says so", "[slots]") {
  const TempFolder folder;
  CHECK(SlotImage::open_for_writing(folder.path() + "/none/b.img").error().reason == Reason::not_found);
  CHECK_FALSE(SlotImage::open_for_writing(folder.path()).ok());
  const std::string pipe = folder / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(SlotImage::open_for_writing(pipe).error().reason == Reason::unsupported);
  CHECK(check_slot_image(folder / "none", {}).error().reason == Reason::not_found);
  const std::string empty = folder / "empty";
  test::write_plain(empty, "");
  CHECK(check_slot_image(empty, {}).error().reason == Reason::truncated);
}

TEST_CASE("a disk without room is noticed before anything is written", "[slots]") {
  const TempFolder folder;
  auto image = SlotImage::open_for_writing(folder / "b.img");
  REQUIRE(image.ok());
  const auto room = image.value().make_room(std::uint64_t{1} << 60);
  REQUIRE_FALSE(room.ok());
  CHECK((room.error().reason == Reason::disk_full || room.error().reason == Reason::too_large));
}

TEST_CASE("a disk that refuses is told by name", "[slots]") {
  class Broken final : public Disk {
   public:
    ssize_t pwrite(int, const void*, std::size_t, off_t) override { return errno = ENOSPC, -1; }
    ssize_t pread(int, void*, std::size_t, off_t) override { return errno = EIO, -1; }
    int fsync(int) override { return errno = EIO, -1; }
  } broken;
  const TempFolder folder;
  const std::string path = folder / "b.img";
  auto image = SlotImage::open_for_writing(path);
  REQUIRE(image.ok());
  const DiskInstead instead(broken);
  std::vector<std::uint8_t> bytes(10);
  CHECK(image.value().write(0, bytes).error().reason == Reason::disk_full);
  CHECK(image.value().read(0, bytes).error().reason == Reason::io_error);
  CHECK(image.value().sync().error().reason == Reason::io_error);
  CHECK_THAT(check_slot_image(path, {}).error().text, Catch::Contains(path));
}
