// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/kernel_setting.hpp"

#include <catch2/catch.hpp>
#include <filesystem>

#include "hal/image/file_bytes.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal::boot;

TEST_CASE("the kernel is told through a file that is there, and none is made", "[boot]") {
  const test::TempFolder folder;
  const std::string file = folder.path() + "/path";
  CHECK_FALSE(set_kernel(file, "/firmware"));
  CHECK_FALSE(std::filesystem::exists(file));
  test::write_plain(file, std::string_view(""));
  CHECK(set_kernel(file, "/firmware"));
  CHECK(hal::read_text_file(file, 64).value() == "/firmware");
  CHECK_FALSE(set_kernel(folder.path(), "a folder takes nothing"));
}
