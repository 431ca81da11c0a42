// SPDX-License-Identifier: Apache-2.0
#include "hal/errand.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;

TEST_CASE("an errand is done in another thread, and seen when it is taken", "[threads]") {
  hal::Errand errand;
  CHECK_FALSE(errand.is_busy());
  errand.wait();  // for nothing
  std::vector<int> written;
  std::thread::id where;
  for (int i = 0; i < 200; ++i) {
    errand.start([&] {
      written.push_back(i);
      where = std::this_thread::get_id();
    });
    CHECK(errand.is_busy());
    if (i % 2 == 0) {
      errand.wait();
    } else {
      while (!errand.is_done()) std::this_thread::yield();
    }
    REQUIRE(errand.is_done());
    errand.take();
    CHECK_FALSE(errand.is_busy());
    REQUIRE(written.size() == static_cast<std::size_t>(i) + 1);
    CHECK(written.back() == i);
    CHECK(where != std::this_thread::get_id());
  }
}

TEST_CASE("an errand that nobody waits for is finished before its owner is gone", "[threads]") {
  int done = 0;
  for (int i = 0; i < 20; ++i) {
    hal::Errand errand;
    errand.start([&] { ++done; });
  }
  CHECK(done == 20);
}
