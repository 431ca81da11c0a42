// SPDX-License-Identifier: Apache-2.0
#include "hal/lease.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <thread>

using namespace g3d;

TEST_CASE("a lease is one's until it is given back", "[lease]") {
  hal::Lease lease;
  REQUIRE(lease.try_take());
  CHECK_FALSE(lease.try_take());
  CHECK_FALSE(lease.try_take());
  lease.give_back();
  CHECK(lease.try_take());
}

TEST_CASE("what is leased is used by one thread at a time", "[lease][threads]") {
  constexpr int kTimes = 20'000;
  hal::Lease lease;
  int uses = 0;  // no atomic: the lease is all that keeps them apart
  const auto use = [&] {
    for (int done = 0; done < kTimes;) {
      if (!lease.try_take()) {
        std::this_thread::yield();
        continue;
      }
      ++uses;
      ++done;
      lease.give_back();
    }
  };
  std::array<std::thread, 3> threads{std::thread(use), std::thread(use), std::thread(use)};
  for (std::thread& thread : threads) thread.join();
  CHECK(uses == 3 * kTimes);
}
