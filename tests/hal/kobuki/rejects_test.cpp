// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/rejects.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

namespace {

using namespace g3d::hal::kobuki;

TEST_CASE("every reject reason has a name of its own") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kRejectCount; ++i) names.insert(to_string(static_cast<Reject>(i)));
  CHECK(names.size() == kRejectCount);
  CHECK(names.count("unknown") == 0);
  CHECK(std::string(to_string(Reject::count_)) == "unknown");
}

TEST_CASE("rejects are counted by reason") {
  RejectCounts rejects;
  rejects.count(Reject::bad_checksum);
  rejects.count(Reject::bad_checksum);
  rejects.count(Reject::time_step);
  CHECK(rejects[Reject::bad_checksum] == 2);
  CHECK(rejects[Reject::time_step] == 1);
  CHECK(rejects[Reject::bad_length] == 0);
  CHECK(rejects.total() == 3);
}

}  // namespace
