// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/memory_lock.hpp"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/support/under_sanitizer.hpp"

using namespace g3d::hal;

TEST_CASE("The program's memory is locked, or it says which limit is in the way", "[memory_lock]") {
  if (g3d::test::is_under_sanitizer()) return;
  // In a process of its own: the rest of the tests has other wishes.
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const auto locked = lock_program_memory();
    if (!locked) ::_exit(locked.error().text.find("LimitMEMLOCK") != std::string::npos ? 0 : 1);
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with("VmLck:")) ::_exit(line.find_first_of("123456789") != std::string::npos ? 0 : 2);
    }
    ::_exit(3);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}
