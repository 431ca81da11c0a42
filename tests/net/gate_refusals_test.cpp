// SPDX-License-Identifier: Apache-2.0
#include "net/gate_refusals.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

namespace {

using namespace g3d::net;

TEST_CASE("every refusal has a name of its own") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kGateRefusalCount; ++i) names.insert(to_string(static_cast<GateRefusal>(i)));
  CHECK(names.size() == kGateRefusalCount);
  CHECK(names.count("unknown") == 0);
  CHECK(to_string(GateRefusal::count_) == std::string("unknown"));
}

TEST_CASE("all that came is the sum of what became of it") {
  GateCounts counts;
  counts.count(GateRefusal::forged);
  counts.count(GateRefusal::forged);
  counts.count(GateRefusal::revoked);
  counts.delivered = 4;
  counts.challenged = counts.answered = counts.proven = counts.proven_again = 1;
  CHECK(counts[GateRefusal::forged] == 2);
  CHECK(counts.refused() == 3);
  CHECK(counts.taken() == 11);
}

}  // namespace
