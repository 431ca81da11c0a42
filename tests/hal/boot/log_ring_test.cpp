// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/log_ring.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::boot::LogRing;

TEST_CASE("the log never grows beyond its bound, and keeps what was said last", "[boot]") {
  const test::TempFolder folder;
  const std::string path = folder.path() + "/log";
  {
    LogRing log({3, 1000});
    REQUIRE(log.open(path).ok());
    for (int i = 0; i < 1000; ++i) log.write(fmt::format("line {}", i));
    CHECK(log.lost_lines() == 0);
    const std::string tail = log.tail(40);
    CHECK(tail.size() <= 40);
    CHECK(tail.ends_with("line 998\nline 999\n"));
    CHECK(tail.starts_with("line 99"));
  }
  std::uintmax_t bytes = 0;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    bytes += entry.file_size();
    ++files;
    CHECK(entry.file_size() <= 1000);
  }
  CHECK(files == 3);
  CHECK(bytes > 1000);
}

TEST_CASE("the log goes on where it was after a restart", "[boot]") {
  const test::TempFolder folder;
  {
    LogRing log({8, 1 << 20});
    REQUIRE(log.open(folder.path()).ok());
    log.write("before");
  }
  LogRing log({8, 1 << 20});
  REQUIRE(log.open(folder.path()).ok());
  log.write("after");
  CHECK(log.tail(1000) == "before\nafter\n");
  log.close();
  log.write("too late");
  CHECK(log.lost_lines() == 1);
  CHECK(test::read_plain(folder.path() + "/0.log") == "before\nafter\n");
}

TEST_CASE("lines that nobody takes are counted", "[boot]") {
  LogRing log({8, 1000});
  log.write("nowhere");
  CHECK(log.lost_lines() == 1);
  CHECK(log.tail(100).empty());
  CHECK_FALSE(log.open("/proc/no/such/folder").ok());
  log.write(std::string(5000, 'x'));
  CHECK(log.lost_lines() == 2);
}
