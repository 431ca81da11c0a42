// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/heap_room.hpp"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/under_sanitizer.hpp"

using namespace g3d::hal;

namespace {

std::uintptr_t end_of_heap() { return reinterpret_cast<std::uintptr_t>(::sbrk(0)); }

/// "hg": large pages were asked for.
bool heap_wants_large_pages() {
  std::ifstream maps("/proc/self/smaps");
  bool is_heap = false;
  for (std::string line; std::getline(maps, line);) {
    if (line.find('-') < line.find(' ')) {  // the addresses of the next mapping
      is_heap = line.ends_with("[heap]");
    } else if (is_heap && line.starts_with("VmFlags:") && line.find(" hg") != std::string::npos) {
      return true;
    }
  }
  return false;
}

/// What is wrong, as a number; 0: nothing.
int use_heap_room() {
  // Some room that is there already, as after other tests.
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 30);
  void* volatile room = std::malloc(std::size_t{24} << 20);
  std::free(room);
  constexpr std::size_t kRoom_bytes = std::size_t{96} << 20, kArray_bytes = std::size_t{1} << 20;
  if (!make_heap_room(kRoom_bytes)) return 1;
  const std::uintptr_t end = end_of_heap();
  std::vector<std::vector<char>> arrays;
  for (int i = 0; i < 80; ++i) {
    arrays.emplace_back(kArray_bytes, '\0');
    const auto at = reinterpret_cast<std::uintptr_t>(arrays.back().data());
    if (at + kArray_bytes > end) return 2;  // a mapping of its own, high above the heap
  }
  arrays.clear();
  if (end_of_heap() != end) return 3;  // given back, or not enough
  const bool has_large_pages = ::access("/sys/kernel/mm/transparent_hugepage/enabled", R_OK) == 0;
  return has_large_pages && ::access("/proc/self/smaps", R_OK) == 0 && !heap_wants_large_pages() ? 4 : 0;
}

}  // namespace

TEST_CASE("Room for the heap is there at once, is used, and stays", "[heap_room]") {
  if (g3d::test::is_under_sanitizer()) return;  // their heap is not the system's
  // In a process of its own: the other tests keep the heap that they know.
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) ::_exit(use_heap_room());
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}
