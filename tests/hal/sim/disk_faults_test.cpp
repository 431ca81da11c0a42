// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/disk_faults.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <string>
#include <thread>

#include "hal/image/atomic_file.hpp"
#include "hal/image/file_bytes.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using g3d::test::read_plain;
using g3d::test::TempFolder;
using g3d::test::write_plain;

namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;

/// A folder with an old file on a disk that fails as of second 1 for ten seconds.
struct BadDisk {
  TempFolder folder;
  std::string path = folder / "map";
  std::atomic<TimeNs> now_ns{0};
  DiskFaults faults;
  DiskInstead instead{faults};

  explicit BadDisk(const std::string& kind)
      : faults({parse_fault("disk:" + kind + "@1+10").value()}, [this] { return now_ns.load(); }) {
    write_plain(path, "old");
  }
  Result<void> write(const std::string& text) { return write_file_atomic(path, text); }
};

}  // namespace

TEST_CASE("a disk that is well does what it is told") {
  BadDisk disk("off");
  REQUIRE(disk.write("new").ok());
  CHECK(read_plain(disk.path) == "new");
}

TEST_CASE("a disk that refuses says why, keeps the old file, and takes the new one afterwards") {
  struct Case {
    const char* kind;
    Reason reason;
  };
  for (const Case& c : {Case{"off", Reason::io_error}, Case{"wrong", Reason::no_permission},
                        Case{"intermittent", Reason::disk_full}, Case{"garbage", Reason::bad_checksum}}) {
    INFO(c.kind);
    BadDisk disk(c.kind);
    disk.now_ns = kSecond_ns;
    const auto refused = disk.write("new");
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().reason == c.reason);
    CHECK(refused.error().text.find(disk.path) == 0);
    CHECK(read_plain(disk.path) == "old");
    CHECK(disk.folder.listing() == "map\n");
    disk.now_ns = 11 * kSecond_ns;
    REQUIRE(disk.write("new").ok());
    CHECK(read_plain(disk.path) == "new");
  }
}

TEST_CASE("a file that was begun before the disk failed is not half there") {
  for (const char* kind : {"off", "wrong", "intermittent"}) {
    INFO(kind);
    BadDisk disk(kind);
    auto file = AtomicFile::create(disk.path);
    REQUIRE(file.ok());
    REQUIRE(file.value().write("new").ok());
    disk.now_ns = kSecond_ns;
    CHECK_FALSE(file.value().commit().ok());
    CHECK(read_plain(disk.path) == "old");
  }
}

TEST_CASE("a full disk has room for half of each second") {
  BadDisk disk("intermittent");
  disk.now_ns = kSecond_ns * 17 / 10;
  CHECK(disk.write("new").ok());
  disk.now_ns = kSecond_ns * 22 / 10;
  CHECK_FALSE(disk.write("newer").ok());
}

TEST_CASE("a disk that hangs goes on when the fault is over", "[threads]") {
  BadDisk disk("stuck");
  disk.now_ns = kSecond_ns;
  std::atomic<bool> is_written{false};
  std::thread writer([&] { is_written = disk.write("new").ok(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  CHECK_FALSE(is_written.load());
  disk.now_ns = 11 * kSecond_ns;
  writer.join();
  CHECK(is_written.load());
  CHECK(read_plain(disk.path) == "new");
}

TEST_CASE("slow and delayed disks take time and nothing else", "[slow]") {
  for (const char* kind : {"slow", "delayed"}) {
    INFO(kind);
    BadDisk disk(kind);
    disk.now_ns = kSecond_ns;
    const auto start = std::chrono::steady_clock::now();
    REQUIRE(disk.write("new").ok());
    CHECK(std::chrono::steady_clock::now() - start >= std::chrono::milliseconds(200));
    CHECK(read_plain(disk.path) == "new");
  }
}
