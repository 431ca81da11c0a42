// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/large_pages.hpp"

#include <catch2/catch.hpp>

#include "hal/image/file_bytes.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal::boot;

TEST_CASE("large pages are allowed for who asks, where the kernel had switched them off", "[boot]") {
  const test::TempFolder folder;
  const std::string file = folder.path() + "/enabled";
  CHECK_FALSE(allow_large_pages(file));
  test::write_plain(file, std::string_view("always madvise [never]\n"));
  REQUIRE(allow_large_pages(file));
  CHECK(hal::read_text_file(file, 64).value().starts_with("madvise"));
  for (const char* text : {"[always] madvise never\n", "always [madvise] never\n"}) {
    test::write_plain(file, std::string_view(text));
    CHECK(allow_large_pages(file));
    CHECK(hal::read_text_file(file, 64).value() == text);
  }
}
