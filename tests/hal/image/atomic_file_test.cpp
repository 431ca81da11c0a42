// SPDX-License-Identifier: Apache-2.0
#include "hal/image/atomic_file.hpp"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <vector>

#include "hal/disk.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using g3d::test::read_plain;
using g3d::test::TempFolder;
using g3d::test::write_plain;

TEST_CASE("The old file stands until commit, then the whole new one") {
  const TempFolder folder;
  const std::string path = folder / "map";
  write_plain(path, "old");
  Result<AtomicFile> created = AtomicFile::create(path);
  REQUIRE(created.ok());
  AtomicFile file = std::move(created).value();
  std::string expected;
  for (int i = 0; i < 200'000; ++i) {
    const std::string line = "line " + std::to_string(i) + "\n";
    REQUIRE(file.write(line).ok());
    expected += line;
  }
  CHECK(file.bytes_written() == expected.size());
  CHECK(read_plain(path) == "old");
  REQUIRE(file.commit().ok());
  CHECK(read_plain(path) == expected);
  CHECK(folder.listing() == "map\n");
  CHECK(file.write("more").error().reason == Reason::bad_usage);
  CHECK(file.commit().error().reason == Reason::bad_usage);
  CHECK(read_plain(path) == expected);
}

TEST_CASE("Abandoned, explicitly or by destruction, it leaves the old file and nothing else") {
  const TempFolder folder;
  const std::string path = folder / "map";
  write_plain(path, "old");
  {
    Result<AtomicFile> file = AtomicFile::create(path);
    REQUIRE(file.ok());
    REQUIRE(file.value().write("new").ok());
  }
  CHECK(folder.listing() == "map\n");
  Result<AtomicFile> file = AtomicFile::create(path);
  REQUIRE(file.ok());
  file.value().abandon();
  file.value().abandon();
  CHECK(folder.listing() == "map\n");
  CHECK(read_plain(path) == "old");
}

TEST_CASE("The part of a killed writer is reused, a living writer's is not") {
  const TempFolder folder;
  const std::string path = folder / "map";
  write_plain(path + ".part", "a longer left-over of a killed process");
  Result<AtomicFile> first = AtomicFile::create(path);
  REQUIRE(first.ok());
  const Result<AtomicFile> second = AtomicFile::create(path);
  REQUIRE_FALSE(second.ok());
  CHECK(second.error().reason == Reason::no_permission);
  REQUIRE(first.value().write("new").ok());
  REQUIRE(first.value().commit().ok());
  CHECK(read_plain(path) == "new");
  CHECK(folder.listing() == "map\n");
}

TEST_CASE("Errors name the path and the remedy") {
  const TempFolder folder;
  const Result<AtomicFile> no_folder = AtomicFile::create(folder.path() + "/none/map");
  REQUIRE_FALSE(no_folder.ok());
  CHECK(no_folder.error().reason == Reason::not_found);
  CHECK(no_folder.error().text.find("/none/map") != std::string::npos);

  // The target is a folder: known only at the rename.
  const std::string path = folder / "map";
  REQUIRE(::mkdir(path.c_str(), 0700) == 0);
  Result<AtomicFile> onto_folder = AtomicFile::create(path);
  REQUIRE(onto_folder.ok());
  CHECK_FALSE(onto_folder.value().commit().ok());
  CHECK(folder.listing() == "map\n");

  if (::geteuid() != 0) {  // root may write everywhere
    REQUIRE(::chmod(folder.path().c_str(), 0500) == 0);
    CHECK(AtomicFile::create(folder.path() + "/b").error().reason == Reason::no_permission);
  }
  CHECK(system_error("x", "cannot write", EROFS).reason == Reason::no_permission);
}

TEST_CASE("A write that fails half-way keeps the old file") {
  const TempFolder folder;
  const std::string path = folder / "map";
  write_plain(path, "old");
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  void (*const handler)(int) = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1'000'000, before.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  bool failed = false;
  Error error{Reason::bad_usage, ""};
  {
    Result<AtomicFile> file = AtomicFile::create(path);
    const std::vector<std::uint8_t> chunk(100'000, 7);
    for (int i = 0; i < 30 && file.ok() && !failed; ++i) {
      if (Result<void> written = file.value().write(chunk); !written) {
        failed = true;
        error = written.error();
      }
    }
    CHECK(file.value().commit().error().reason == Reason::too_large);  // sticky
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  CHECK(failed);
  CHECK(error.reason == Reason::too_large);
  CHECK(read_plain(path) == "old");
  CHECK(folder.listing() == "map\n");
}

TEST_CASE("A full disk is reported as such, with the remedy") {
  const Error error = system_error("map", "cannot write", ENOSPC);
  CHECK(error.reason == Reason::disk_full);
  CHECK(error.text.find("free some space") != std::string::npos);
}

TEST_CASE("What a disk does not give back as it was written does not replace the old file") {
  class Forgetful final : public Disk {
   public:
    ssize_t pread(int fd, void* out, std::size_t size_bytes, off_t offset) override {
      const ssize_t n = Disk::pread(fd, out, size_bytes, offset);
      if (n > 0 && offset <= wrong_at && wrong_at < offset + n) static_cast<char*>(out)[wrong_at - offset] ^= 1;
      return cut > 0 ? std::min<ssize_t>(n, std::max<off_t>(cut - offset, 0)) : n;
    }
    off_t wrong_at = -1;
    off_t cut = 0;
  } disk;
  const DiskInstead instead(disk);
  const TempFolder folder;
  const std::string path = folder / "map";
  write_plain(path, "old");
  const std::string text(700'000, 'x');
  const auto save = [&]() -> Result<void> {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return file.error();
    if (Result<void> written = file.value().write(text); !written) return written;
    return file.value().commit();
  };
  disk.wrong_at = 650'000;
  CHECK(save().error().reason == Reason::bad_checksum);
  disk.wrong_at = -1;
  disk.cut = 600'000;
  CHECK(save().error().reason == Reason::bad_checksum);
  CHECK(read_plain(path) == "old");
  CHECK(folder.listing() == "map\n");
  disk.cut = 0;
  CHECK(save().ok());
  CHECK(read_plain(path) == text);
}

TEST_CASE("A private file is its owner's alone from the first byte on") {
  const TempFolder folder;
  const std::string path = folder / "key";
  const auto mode_of = [](const std::string& name) {
    struct stat status {};
    REQUIRE(::stat(name.c_str(), &status) == 0);
    return status.st_mode & 07777;
  };
  write_plain(path, "old, for all to read");
  const mode_t before = ::umask(0);
  Result<AtomicFile> file = AtomicFile::create_private(path);
  ::umask(before);
  REQUIRE(file.ok());
  CHECK(mode_of(path + ".part") == 0600);
  REQUIRE(file.value().write("secret").ok());
  REQUIRE(file.value().commit().ok());
  CHECK(mode_of(path) == 0600);
  CHECK(read_plain(path) == "secret");
}

TEST_CASE("A private file is not written into what others hold open or have linked") {
  const TempFolder folder;
  const std::string path = folder / "key", part = path + ".part";
  write_plain(part, "left behind");
  REQUIRE(::chmod(part.c_str(), 0644) == 0);
  const Result<AtomicFile> readable = AtomicFile::create_private(path);
  REQUIRE_FALSE(readable.ok());
  CHECK(readable.error().reason == Reason::no_permission);
  CHECK(readable.error().text.find("remove it") != std::string::npos);
  REQUIRE(::chmod(part.c_str(), 0600) == 0);
  REQUIRE(::link(part.c_str(), (folder / "other").c_str()) == 0);
  CHECK_FALSE(AtomicFile::create_private(path).ok());
  REQUIRE(::unlink((folder / "other").c_str()) == 0);
  CHECK(AtomicFile::create_private(path).ok());
}
