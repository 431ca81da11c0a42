// SPDX-License-Identifier: Apache-2.0
#include "hal/latest.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <thread>

using namespace g3d::hal;

TEST_CASE("Latest counts generations and keeps the newest value") {
  Latest<std::array<float, 5>> latest;
  std::array<float, 5> out{1, 1, 1, 1, 1};
  CHECK(latest.read(out) == 0);
  CHECK(out[0] == 1);
  std::uint64_t seen = 0;
  CHECK_FALSE(latest.read_newer(seen, out));
  for (std::uint64_t i = 1; i <= 10; ++i) {
    latest.write({static_cast<float>(i), 2, 3, 4, 5});
    CHECK(latest.generation() == i);
    CHECK(latest.read(out) == i);
    CHECK(out == std::array<float, 5>{static_cast<float>(i), 2, 3, 4, 5});
  }
  CHECK(latest.read_newer(seen, out));
  CHECK(seen == 10);
  CHECK_FALSE(latest.read_newer(seen, out));
}

TEST_CASE("Readers get whole values and their generation while the writer writes", "[threads]") {
  constexpr std::uint64_t kCount = 100'000;
  using Value = std::array<std::uint64_t, 6>;
  Latest<Value> latest;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kCount; ++i) {
      Value value;
      value.fill(i);
      latest.write(value);
      if (i % 128 == 0) std::this_thread::yield();
    }
  });
  const auto count_bad = [&] {
    std::uint64_t bad = 0;
    std::uint64_t last = 0;
    while (last < kCount) {
      Value value{};
      const std::uint64_t generation = latest.read(value);
      if (generation < last) ++bad;
      for (const std::uint64_t word : value) {
        if (word != generation) ++bad;
      }
      last = generation;
    }
    return bad;
  };
  std::uint64_t bad_second = 0;
  std::thread second_reader([&] { bad_second = count_bad(); });
  CHECK(count_bad() == 0);
  second_reader.join();
  writer.join();
  CHECK(bad_second == 0);
}
