// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/mounts.hpp"

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal::boot;

TEST_CASE("partitions are found by the names that the partition table gives them", "[boot]") {
  const test::TempFolder folder;
  const auto add = [&](const std::string& device, const std::string& lines) {
    test::write_plain(folder / (device + "/uevent"), "MAJOR=254\nDEVNAME=" + device + "\nDEVTYPE=partition\n" + lines);
  };
  add("vda", "");
  add("vda1", "PARTN=1\nPARTNAME=boot\n");
  add("vda4", "PARTN=4\nPARTNAME=data\n");
  add("vdb1", "PARTN=1\nPARTNAME=data\n");
  CHECK(find_partition("boot", folder.path()) == "/dev/vda1");
  CHECK(find_partition("data", folder.path()) == "/dev/vda4");  // of two the first, whatever the order of the folder
  CHECK_FALSE(find_partition("dat", folder.path()));
  CHECK_FALSE(find_partition("system-a", folder.path()));
  CHECK_FALSE(find_partition("data", folder.path() + "/none"));
}

TEST_CASE("values are read by their whole key", "[boot]") {
  CHECK(value_in("AB=1\nA=2\n", "A") == "2");
  CHECK(value_in("A=x=y", "A") == "x=y");
  CHECK(value_in("A=\nB", "A").empty());
  CHECK(value_in("A=\nB", "B").empty());
}

TEST_CASE("an option of the kernel's command line is a whole word", "[boot]") {
  CHECK(kernel_option("quiet g3d.slot=b panic=5\n", "g3d.slot") == "b");
  CHECK(kernel_option("xg3d.slot=b", "g3d.slot").empty());
  CHECK(kernel_option("g3d.slots=b", "g3d.slot").empty());
  CHECK(kernel_option("", "g3d.slot").empty());
}

TEST_CASE("what cannot be mounted is an error that names it", "[boot]") {
  const test::TempFolder folder;
  const auto mounted = mount_ext4("/dev/no_such_device", folder.path() + "/here", MountAs::writable);
  REQUIRE_FALSE(mounted.ok());
  CHECK(mounted.error().text.find("/dev/no_such_device") != std::string::npos);
  CHECK_FALSE(end_writing(folder.path() + "/here").ok());
}
