// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/stamp_fit.hpp"

#include <catch2/catch.hpp>

using g3d::hal::StampFit;
using g3d::hal::TimeNs;

namespace {

constexpr TimeNs kMs = 1'000'000;
constexpr TimeNs kApart = 7'000'000 * kMs;  // between the two clocks

}  // namespace

TEST_CASE("a message that waited is not taken for a new one") {
  StampFit fit;
  CHECK(fit.to_ours(0, kApart + 3 * kMs) == kApart + 3 * kMs);
  CHECK(fit.to_ours(100 * kMs, kApart + 102 * kMs) == kApart + 102 * kMs);
  CHECK(fit.to_ours(200 * kMs, kApart + 900 * kMs) == kApart + 202 * kMs);
  CHECK(fit.waited_ns() == 698 * kMs);
}

TEST_CASE("what was old when the stream was opened is put right by what comes, and time does not go back") {
  StampFit fit;
  const TimeNs first = fit.to_ours(0, kApart + 5000 * kMs);  // had waited five seconds
  CHECK(first == kApart + 5000 * kMs);
  const TimeNs second = fit.to_ours(200 * kMs, kApart + 5001 * kMs);
  CHECK(second > first);
  CHECK(second <= kApart + 5001 * kMs);
  TimeNs last = second;
  for (int i = 26; i < 60; ++i) {
    const TimeNs now = kApart + i * 200 * kMs + 2 * kMs;
    const TimeNs at = fit.to_ours(i * 200 * kMs, now);
    CHECK(at > last);
    last = at;
  }
  CHECK(last == kApart + 59 * 200 * kMs + 2 * kMs);
}

TEST_CASE("clocks that drift apart are followed") {
  StampFit fit;
  TimeNs last = 0;
  for (TimeNs theirs = 0; theirs < 120'000 * kMs; theirs += 200 * kMs) {
    last = fit.to_ours(theirs, kApart + theirs + theirs / 10'000 + kMs);  // ours is 100 ppm fast
    const TimeNs late = kApart + theirs + theirs / 10'000 + kMs - last;
    CHECK(late >= 0);
    CHECK(late <= 3 * kMs);
  }
}

TEST_CASE("a stamp that is repeated stays, and another clock is begun with anew") {
  StampFit fit;
  const TimeNs at = fit.to_ours(100 * kMs, kApart);
  CHECK(fit.to_ours(100 * kMs, kApart + 50 * kMs) == at);
  fit.forget();
  CHECK(fit.to_ours(1, 5 * kMs) == 5 * kMs);
}
