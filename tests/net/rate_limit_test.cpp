// SPDX-License-Identifier: Apache-2.0
#include "net/rate_limit.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace g3d;
using namespace g3d::net;

constexpr RateLimits kLimits{.per_source = {100.0, 20.0}, .overall = {300.0, 60.0}, .forged_cost = 10.0};
constexpr hal::TimeNs kMs = hal::kMillisecond_ns;

int admitted(RateLimit& limit, std::uint64_t source, RateClass rate_class, int asked, hal::TimeNs now_ns) {
  int count = 0;
  for (int i = 0; i < asked; ++i) count += limit.admit(source, rate_class, now_ns) == RateVerdict::admitted ? 1 : 0;
  return count;
}

TEST_CASE("sources differ in address and port") {
  CHECK(source_of(0x7F000001, 5000) != source_of(0x7F000001, 5001));
  CHECK(source_of(0x7F000001, 5000) != source_of(0x7F000002, 5000));
  CHECK(source_of(0xFFFFFFFF, 0xFFFF) == 0xFFFF'FFFF'FFFF);
}

TEST_CASE("a flood from one source leaves others alone") {
  RateLimit limit(kLimits, 64);
  int flood = 0, peer = 0;
  for (int ms = 0; ms < 10'000; ++ms) {
    flood += admitted(limit, 1, RateClass::stranger, 20, ms * kMs);
    if (ms % 20 == 0) peer += admitted(limit, 2, RateClass::stranger, 1, ms * kMs);
  }
  CHECK(peer == 500);
  CHECK(flood == Approx(1020).margin(2));
  CHECK(limit.admit(1, RateClass::stranger, 9'999 * kMs) == RateVerdict::source_rate);
}

TEST_CASE("a flood from many sources stops at the limit of all, and known ones go on") {
  RateLimit limit(kLimits, 64);
  int flood = 0, known = 0;
  for (int ms = 0; ms < 10'000; ++ms) {
    for (std::uint64_t i = 0; i < 20; ++i) {
      flood += admitted(limit, 1'000'000 + static_cast<std::uint64_t>(ms) * 20 + i, RateClass::stranger, 1, ms * kMs);
    }
    if (ms % 20 == 0) known += admitted(limit, 7, RateClass::known, 1, ms * kMs);
  }
  CHECK(known == 500);
  CHECK(flood == Approx(3060).margin(4));
  CHECK(limit.admit(5, RateClass::stranger, 9'999 * kMs) == RateVerdict::overall_rate);
}

TEST_CASE("known sources are limited as well, each by itself") {
  RateLimit limit(kLimits, 64);
  for (std::uint64_t source = 0; source < 10; ++source) CHECK(admitted(limit, source, RateClass::known, 100, 0) == 20);
}

TEST_CASE("forged datagrams cost more, and the debt ends") {
  RateLimit limit(kLimits, 64);
  int read = 0;
  for (int ms = 0; ms < 10'000; ++ms) {
    if (limit.admit(1, RateClass::stranger, ms * kMs) != RateVerdict::admitted) continue;
    ++read;
    limit.charge_forged(1, ms * kMs);
  }
  CHECK(read < 100);
  CHECK(read > 50);
  CHECK(admitted(limit, 1, RateClass::stranger, 100, 11'000 * kMs) == 20);
}

TEST_CASE("a table that is full forgets those in least debt") {
  RateLimit limit(kLimits, 8);  // one set
  CHECK(admitted(limit, 1, RateClass::known, 100, 0) == 20);
  for (std::uint64_t source = 100; source < 200; ++source) CHECK(admitted(limit, source, RateClass::known, 1, 0) == 1);
  CHECK(admitted(limit, 1, RateClass::known, 100, 0) == 0);
}

}  // namespace
