// SPDX-License-Identifier: Apache-2.0
#include "net/word_age.hpp"

#include <catch2/catch.hpp>

using namespace g3d;

namespace {
constexpr hal::TimeNs kMs_ns = 1'000'000;
}

TEST_CASE("a word that came by a detour is as old as the detour was long, whatever the clocks say", "[net][status]") {
  net::WordAge age;
  // The other's clock is about to wrap around.
  const std::uint32_t start_ms = 0xFFFFFF00U;
  hal::TimeNs now_ns = 5'000 * kMs_ns;
  (void)age.note(start_ms, now_ns + 3 * kMs_ns);
  for (std::uint32_t i = 1; i < 100; ++i) {
    const hal::TimeNs way_ns = (i % 10 == 7 ? 250 : 3) * kMs_ns;
    const hal::TimeNs told_ns = age.note(start_ms + 400 * i, now_ns + 400 * i * kMs_ns + way_ns);
    CHECK(told_ns <= now_ns + 400 * i * kMs_ns + way_ns);
    // The least that any word took counts as nothing.
    CHECK(std::abs(told_ns - (now_ns + 400 * i * kMs_ns + 3 * kMs_ns)) < 9 * kMs_ns);
  }
}

TEST_CASE("clocks that run apart do not make words old", "[net][status]") {
  net::WordAge age;
  // The sender's clock is slow by 100 ppm, over three hours: by its own account its words come ever later.
  hal::TimeNs worst_ns = 0;
  for (std::int64_t i = 0; i < 27'000; ++i) {
    const hal::TimeNs now_ns = i * 400 * kMs_ns;
    const auto said_ms = static_cast<std::uint32_t>(now_ns / kMs_ns - now_ns / kMs_ns / 10'000);
    worst_ns = std::max(worst_ns, now_ns + 2 * kMs_ns - age.note(said_ms, now_ns + 2 * kMs_ns));
  }
  CHECK(worst_ns < 5 * kMs_ns);
}

TEST_CASE("a first word that came late is put right by the next one", "[net][status]") {
  net::WordAge age;
  CHECK(age.note(1000, 9000 * kMs_ns) == 9000 * kMs_ns);
  CHECK(age.note(2000, 9500 * kMs_ns) == 9500 * kMs_ns);
  CHECK(age.note(3000, 10'500 * kMs_ns) == 10'500 * kMs_ns);
  CHECK(age.note(4000, 11'700 * kMs_ns) < 11'510 * kMs_ns);
}
