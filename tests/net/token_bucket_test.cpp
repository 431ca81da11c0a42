// SPDX-License-Identifier: Apache-2.0
#include "net/token_bucket.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace g3d;
using namespace g3d::net;

constexpr TokenRate kTen{10.0, 5.0};
constexpr hal::TimeNs kSecond_ns = 1000 * hal::kMillisecond_ns;

int take_all(TokenBucket& bucket, hal::TimeNs now_ns) {
  int taken = 0;
  while (bucket.take(kTen, now_ns)) ++taken;
  return taken;
}

TEST_CASE("a bucket gives its burst at once, then its rate") {
  for (const hal::TimeNs begin_ns : {-5 * kSecond_ns, hal::TimeNs{0}, 1'000'000 * kSecond_ns}) {
    TokenBucket bucket;
    CHECK(take_all(bucket, begin_ns) == 5);
    CHECK_FALSE(bucket.take(kTen, begin_ns + 99 * hal::kMillisecond_ns));
    CHECK(bucket.take(kTen, begin_ns + 100 * hal::kMillisecond_ns));
    CHECK(take_all(bucket, begin_ns + kSecond_ns) == 5);
  }
}

TEST_CASE("over a long time nothing but the rate counts") {
  TokenBucket bucket;
  int taken = 0;
  for (hal::TimeNs now_ns = 0; now_ns < 100 * kSecond_ns; now_ns += hal::kMillisecond_ns) {
    taken += bucket.take(kTen, now_ns) ? 1 : 0;
  }
  CHECK(taken == Approx(1004).margin(1));
}

TEST_CASE("a debt silences, for a bounded time") {
  TokenBucket bucket;
  bucket.charge(kTen, 3.0, 0);
  CHECK(take_all(bucket, 0) == 2);
  for (int i = 0; i < 1000; ++i) bucket.charge(kTen, 1000.0, 0);
  CHECK_FALSE(bucket.holds_one(kTen, 599 * hal::kMillisecond_ns));
  CHECK(bucket.holds_one(kTen, 600 * hal::kMillisecond_ns));
}

TEST_CASE("a clock that is set back does not close the bucket for long") {
  TokenBucket bucket;
  CHECK(take_all(bucket, 1000 * kSecond_ns) == 5);
  CHECK(take_all(bucket, 0) == 0);
  bucket.charge(kTen, 1.0, 0);
  CHECK(take_all(bucket, kSecond_ns) == 5);
}

}  // namespace
