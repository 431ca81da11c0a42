// SPDX-License-Identifier: Apache-2.0
// What the kernel's driver is told; that it bites is seen in the emulated machine.
#include "hal/linux/watchdog.hpp"

#include <fcntl.h>

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;

TEST_CASE("A watchdog is fed, and disarmed by the magic close alone", "[watchdog]") {
  const test::TempFolder folder;
  const std::string path = folder / "dog";
  {
    LinuxWatchdog dog(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), 15, "test");
    CHECK(dog.feed());
    CHECK(dog.feed());
  }
  CHECK(test::read_plain(path) == "kk");  // it died: no V
  {
    LinuxWatchdog dog(::open(path.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC), 15, "test");
    CHECK(dog.feed());
    dog.disarm();
    dog.disarm();
    CHECK_FALSE(dog.feed());
  }
  CHECK(test::read_plain(path) == "kV");
}

TEST_CASE("What is no watchdog is refused", "[watchdog]") {
  const test::TempFolder folder;
  CHECK(LinuxWatchdog::open(folder / "none", 15).error().reason == Reason::not_found);
  test::write_plain(folder / "file", "");
  CHECK(LinuxWatchdog::open(folder / "file", 15).error().reason == Reason::unsupported);
  CHECK(test::read_plain(folder / "file").empty());
}
