// SPDX-License-Identifier: Apache-2.0
#include "mapper/page_file.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/temp_folder.hpp"

using namespace g3d;

TEST_CASE("a page file keeps bytes and has no name", "[mapper][paging]") {
  const test::TempFolder folder;
  auto file = mapper::create_page_file(folder.path());
  REQUIRE(file.ok());
  CHECK(folder.listing().empty());
  mapper::PageFile& pages = *file.value();
  const std::vector<std::uint8_t> bytes{1, 2, 3, 4, 5};
  REQUIRE(pages.write(1000, bytes).ok());
  std::vector<std::uint8_t> back(5);
  REQUIRE(pages.read(1000, back).ok());
  CHECK(back == bytes);
  std::vector<std::uint8_t> gap(4, 9);
  REQUIRE(pages.read(996, gap).ok());
  CHECK(gap == std::vector<std::uint8_t>(4, 0));
}

TEST_CASE("reading past the end is an error, also after shortening", "[mapper][paging]") {
  const test::TempFolder folder;
  auto file = mapper::create_page_file(folder.path());
  REQUIRE(file.ok());
  const std::vector<std::uint8_t> bytes(100, 7);
  REQUIRE(file.value()->write(0, bytes).ok());
  std::vector<std::uint8_t> back(101);
  CHECK(file.value()->read(0, back).error().reason == hal::Reason::truncated);
  REQUIRE(file.value()->truncate(50).ok());
  back.resize(51);
  CHECK_FALSE(file.value()->read(0, back).ok());
  back.resize(50);
  CHECK(file.value()->read(0, back).ok());
}

TEST_CASE("a folder that is not there is named in the error", "[mapper][paging]") {
  const test::TempFolder folder;
  const auto file = mapper::create_page_file(folder.path() + "/missing");
  REQUIRE_FALSE(file.ok());
  CHECK(file.error().reason == hal::Reason::not_found);
  CHECK(file.error().text.find("missing") != std::string::npos);
}

TEST_CASE("a disk without room is an error", "[mapper][paging]") {
  auto file = mapper::create_page_file("/dev/shm");
  if (!file.ok()) return;
  // Larger than any file may be.
  CHECK_FALSE(file.value()->write(~std::uint64_t{0} >> 1, std::vector<std::uint8_t>(10)).ok());
  CHECK_FALSE(file.value()->truncate(~std::uint64_t{0}).ok());
}
