// SPDX-License-Identifier: Apache-2.0
#include "mapper/region_table.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

TEST_CASE("the list of resident regions is what was added and not removed", "[mapper][paging]") {
  tests::Random random(1);
  RegionTable table(50);
  std::set<RegionKey> plain;
  for (int i = 0; i < 5000; ++i) {
    const RegionKey region = random.below(50) * 1000;
    if (random.below(2) == 0) {
      REQUIRE(table.add_resident(region) != nullptr);
      plain.insert(region);
    } else if (plain.erase(region) > 0) {
      table.remove_resident(region);
    }
    std::vector<RegionKey> listed(table.resident().begin(), table.resident().end());
    std::sort(listed.begin(), listed.end());
    REQUIRE(listed == std::vector<RegionKey>(plain.begin(), plain.end()));
    for (const RegionKey r : plain) REQUIRE(table.find(r)->resident());
  }
}

TEST_CASE("a region is forgotten only when it is nowhere", "[mapper][paging]") {
  RegionTable table(10);
  table.add_resident(5)->on_disk = true;
  table.add_resident(6);
  table.remove_resident(5);
  table.remove_resident(6);
  REQUIRE(table.find(5) != nullptr);
  CHECK_FALSE(table.find(5)->resident());
  CHECK(table.find(6) == nullptr);
  CHECK(table.size() == 1);
}

TEST_CASE("a full table takes no new region", "[mapper][paging]") {
  RegionTable table(2);
  CHECK(table.add_resident(1) != nullptr);
  CHECK(table.add_resident(2) != nullptr);
  CHECK(table.add_resident(3) == nullptr);
  CHECK(table.add_resident(2) != nullptr);
  CHECK(table.resident().size() == 2);
}
