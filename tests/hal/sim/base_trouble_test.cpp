// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/base_trouble.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace g3d::hal;

namespace {

constexpr TimeNs kMs = 1'000'000;

BaseTrouble trouble(const std::string& fault, TimeNs now_ns = 0) {
  return base_trouble_at({parse_fault(fault).value()}, now_ns, {});
}

}  // namespace

TEST_CASE("without a fault of its own the base is as it is usually") {
  SimKobukiOptions usual;
  usual.to_host.latency_ns = 3 * kMs;
  const BaseTrouble well = base_trouble_at({}, 0, usual);
  CHECK(well.faults == KobukiFaults{});
  CHECK(well.to_host == usual.to_host);
  CHECK(base_trouble_at({parse_fault("camera:off").value(), parse_fault("disk:off").value()}, 0, usual) == well);
  CHECK(base_trouble_at({parse_fault("line:off@1").value()}, 0, usual) == well);
}

TEST_CASE("every kind of fault of odometry and line does something of its own") {
  for (const char* part : {"odometry", "line"}) {
    for (int kind = 1; kind < static_cast<int>(FaultKind::count_); ++kind) {
      const std::string name = std::string(part) + ":" + to_string(static_cast<FaultKind>(kind));
      INFO(name);
      CHECK_FALSE(trouble(name) == BaseTrouble{});
    }
  }
  CHECK(trouble("odometry:off").faults.left_dead);
  CHECK(trouble("odometry:off").faults.right_dead);
  CHECK_FALSE(trouble("odometry:wrong").faults.right_dead);
  CHECK(trouble("line:off").faults.unplugged);
  CHECK(trouble("line:stuck").faults.silent);
  // Odometry comes late, commands do not; a late line holds up both.
  CHECK(trouble("odometry:delayed").to_base == LineNoise{});
  CHECK(trouble("line:delayed").to_base.latency_ns == trouble("line:delayed").to_host.latency_ns);
}

TEST_CASE("a loose contact opens and closes") {
  CHECK(trouble("line:intermittent", 299 * kMs).faults.unplugged);
  CHECK_FALSE(trouble("line:intermittent", 300 * kMs).faults.unplugged);
  CHECK(trouble("line:intermittent", 1'000 * kMs).faults.unplugged);
  CHECK(trouble("odometry:intermittent", 999 * kMs).faults.left_dead);
  CHECK_FALSE(trouble("odometry:intermittent", 1'000 * kMs).faults.left_dead);
}

TEST_CASE("odometry and line may fail at the same time") {
  const BaseTrouble both =
      base_trouble_at({parse_fault("odometry:off").value(), parse_fault("line:delayed").value()}, 0, {});
  CHECK(both.faults.left_dead);
  CHECK(both.to_host.latency_ns == 150 * kMs);
}
