// SPDX-License-Identifier: Apache-2.0
#include "hal/result.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <set>

using namespace g3d::hal;

namespace {

Result<std::unique_ptr<int>> halve(int n) {
  if (n % 2 != 0) return Error{Reason::bad_usage, "n is odd; give an even number"};
  return std::make_unique<int>(n / 2);
}

Result<void> check(bool good) {
  if (!good) return Error{Reason::io_error, "not good"};
  return {};
}

}  // namespace

TEST_CASE("A result is a value or an error, also of what can only be moved") {
  Result<std::unique_ptr<int>> good = halve(8);
  REQUIRE(good.ok());
  const std::unique_ptr<int> value = std::move(good).value();
  CHECK(*value == 4);
  const Result<std::unique_ptr<int>> bad = halve(7);
  REQUIRE_FALSE(bad.ok());
  CHECK_FALSE(static_cast<bool>(bad));
  CHECK(bad.error().reason == Reason::bad_usage);
  CHECK(bad.error().text == "n is odd; give an even number");
  CHECK(check(true).ok());
  CHECK(check(false).error().reason == Reason::io_error);
}

TEST_CASE("Every reason has a name of its own") {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(Reason::bad_usage); ++i) names.insert(to_string(static_cast<Reason>(i)));
  CHECK(names.size() == 12);
  CHECK(names.count("unknown") == 0);
}
