// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/fault_plan.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace g3d::hal;

namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;

}  // namespace

TEST_CASE("a fault is read with its times, or with those that are left out") {
  const PlannedFault whole = parse_fault("camera:stuck@20+5").value();
  CHECK(whole.part == FaultPart::camera);
  CHECK(whole.kind == FaultKind::stuck);
  CHECK(whole.from_ns == 20 * kSecond_ns);
  CHECK(whole.to_ns == 25 * kSecond_ns);
  CHECK(parse_fault("line:off@1.5").value().from_ns == kSecond_ns * 3 / 2);
  CHECK(parse_fault("line:off@1.5").value().to_ns == PlannedFault::kForEver_ns);
  CHECK(parse_fault("disk:delayed").value().from_ns == 0);
}

TEST_CASE("every part and kind has a name that is read back") {
  for (int part = 0; part < static_cast<int>(FaultPart::count_); ++part) {
    for (int kind = 1; kind < static_cast<int>(FaultKind::count_); ++kind) {
      const auto p = static_cast<FaultPart>(part);
      const auto k = static_cast<FaultKind>(kind);
      const auto fault = parse_fault(std::string(to_string(p)) + ":" + to_string(k) + "@1+1");
      REQUIRE(fault.ok());
      CHECK(fault.value().part == p);
      CHECK(fault.value().kind == k);
    }
  }
}

TEST_CASE("what is no fault is refused, and the text says what is one") {
  for (const char* text : {"",
                           ":",
                           "camera",
                           "camera:",
                           ":off",
                           "camera:none",
                           "wheel:off",
                           "camera:late",
                           "camera:off@",
                           "camera:off@x",
                           "camera:off@-1",
                           "camera:off@1+",
                           "camera:off@1+0",
                           "camera:off@1+-1",
                           "camera:off@1e9",
                           "camera:off@nan",
                           "camera:off+1",
                           "Camera:off",
                           "camera:off@1+1+1",
                           "camera:off@1@1",
                           "camera@1:off"}) {
    INFO(text);
    const auto fault = parse_fault(text);
    REQUIRE_FALSE(fault.ok());
    CHECK(fault.error().reason == Reason::bad_usage);
    CHECK(fault.error().text.find("camera:stuck@20+5") != std::string::npos);
  }
  CHECK(parse_fault(std::string(100'000, 'x')).error().text.size() < 1000);
}

TEST_CASE("a fault holds from its beginning to before its end, the last of several counts") {
  const FaultPlan plan{parse_fault("line:off@2+3").value(), parse_fault("line:slow@4").value(),
                       parse_fault("disk:off@0+1").value()};
  CHECK(fault_at(plan, FaultPart::line, 2 * kSecond_ns - 1).kind == FaultKind::none);
  CHECK(fault_at(plan, FaultPart::line, 2 * kSecond_ns).kind == FaultKind::off);
  CHECK(fault_at(plan, FaultPart::line, 3 * kSecond_ns).since_ns == kSecond_ns);
  CHECK(fault_at(plan, FaultPart::line, 4 * kSecond_ns).kind == FaultKind::slow);
  CHECK(fault_at(plan, FaultPart::line, 4 * kSecond_ns).since_ns == 0);
  CHECK(fault_at(plan, FaultPart::disk, kSecond_ns).kind == FaultKind::none);
  CHECK(fault_at(plan, FaultPart::camera, 4 * kSecond_ns).kind == FaultKind::none);
  CHECK(has_fault_of(plan, FaultPart::disk));
  CHECK_FALSE(has_fault_of(plan, FaultPart::camera));
}
