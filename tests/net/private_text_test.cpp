// SPDX-License-Identifier: Apache-2.0
#include "net/private_text.hpp"

#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using net::PrivateText;
using net::read_private_text;

TEST_CASE("a private text is read, whole or not at all") {
  const test::TempFolder folder;
  const std::string path = folder / "secret";
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, PrivateText::kMost_bytes, PrivateText::kMost_bytes + 1}) {
    test::write_plain(path, std::string(size, 's'));
    REQUIRE(::chmod(path.c_str(), 0600) == 0);
    PrivateText text;
    const auto read = read_private_text(path, "sort of key", "make another", text);
    REQUIRE(read.ok() == (size <= PrivateText::kMost_bytes));
    if (read.ok()) CHECK(text.view() == std::string(size, 's'));
    if (!read.ok()) CHECK_THAT(read.error().text, Catch::Contains("no sort of key has"));
  }
}

TEST_CASE("a text that others can get at says what to do") {
  const test::TempFolder folder;
  const std::string path = folder / "secret";
  test::write_plain(path, "s");
  REQUIRE(::chmod(path.c_str(), 0644) == 0);
  PrivateText text;
  const auto read = read_private_text(path, "sort of key", "make another", text);
  REQUIRE_FALSE(read.ok());
  CHECK(read.error().reason == hal::Reason::no_permission);
  CHECK_THAT(read.error().text, Catch::Contains("mode 0644") && Catch::Contains("make another if they may have"));
  CHECK(read_private_text(folder / "none", "k", "m", text).error().reason == hal::Reason::not_found);
  CHECK(read_private_text(folder.path(), "k", "m", text).error().reason == hal::Reason::unsupported);
}
