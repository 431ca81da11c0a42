// SPDX-License-Identifier: Apache-2.0
// The machines that tests run on have no GPIO chip; lines that move are met in the emulated machine.
#include "hal/linux/gpio_chip.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

TEST_CASE("An edge's stamp is brought to our clock, whichever it is of", "[gpio]") {
  constexpr TimeNs kMonotonic_ns = 50'000'000'000, kReal_ns = 1'700'000'000'000'000'000;
  CHECK(monotonic_edge_ns(kMonotonic_ns - 1'000, kMonotonic_ns, kReal_ns) == kMonotonic_ns - 1'000);
  CHECK(monotonic_edge_ns(kReal_ns - 1'000, kMonotonic_ns, kReal_ns) == kMonotonic_ns - 1'000);
  // A reading of ours that is a little older than the edge.
  CHECK(monotonic_edge_ns(kMonotonic_ns + 1'000, kMonotonic_ns, kReal_ns) == kMonotonic_ns + 1'000);
  CHECK_FALSE(monotonic_edge_ns(0, kMonotonic_ns + 100'000'000'000, kReal_ns));
  CHECK_FALSE(monotonic_edge_ns(kReal_ns + 1'000'000'000, kMonotonic_ns, kReal_ns));
}

TEST_CASE("A GPIO chip that is not there is an error with a remedy", "[gpio]") {
  GpioChipOptions options;
  options.chip = "no-such-chip";
  options.inputs[0] = "estop";
  const auto chip = GpioChip::open(options);
  REQUIRE_FALSE(chip.ok());
  CHECK(chip.error().reason == Reason::not_found);
  CHECK(chip.error().text.find("no-such-chip: no such GPIO chip") == 0);
  options.bias = "sideways";
  CHECK(GpioChip::open(options).error().reason == Reason::bad_usage);
}
