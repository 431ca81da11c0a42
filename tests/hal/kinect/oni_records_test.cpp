// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "hal/kinect/oni_records.hpp"
#include "tests/support/oni_builder.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

TEST_CASE("records of an .oni file are walked from its header to its end, within its bounds") {
  const auto bytes = g3d::test::small_oni(32, 16, 2);
  OniRecords records(bytes, "a.oni");
  REQUIRE(records.read_header().ok());
  CHECK(records.header().is_wide);
  CHECK(records.header().last_stamp_us == 1'000'000);
  CHECK(records.header().highest_node == 2);
  std::size_t at = OniRecords::kFileHeader_bytes, count = 0, images = 0;
  for (;; ++count) {
    const auto record = records.read(at);
    REQUIRE(record.ok());
    images += record.value().type == kNewData;
    at = records.end_of(record.value());
    if (record.value().type == kEnd) break;
  }
  CHECK(at == bytes.size());
  CHECK(images == 4);
  CHECK(records.read(at).error().reason == Reason::truncated);
  CHECK(records.read(at + 1).error().reason == Reason::truncated);
  CHECK(records.read(25).error().reason == Reason::malformed);
}

TEST_CASE("fields end where their record ends, and texts with a zero") {
  const std::vector<std::uint8_t> bytes{3, 0, 0, 0, 'a', 'b', 0, 7, 0};
  OniFields fields{bytes};
  CHECK(fields.text(10) == "ab");
  CHECK(fields.number<std::uint16_t>() == 7);
  CHECK(fields.ok);
  (void)fields.number<std::uint8_t>();
  CHECK_FALSE(fields.ok);
  for (const std::vector<std::uint8_t>& bad :
       {std::vector<std::uint8_t>{3, 0, 0, 0, 'a', 'b', 'c'}, std::vector<std::uint8_t>{3, 0, 0, 0, 'a', 0, 0},
        std::vector<std::uint8_t>{0, 0, 0, 0}, std::vector<std::uint8_t>{255, 255, 255, 255, 'a', 0}}) {
    OniFields text{bad};
    (void)text.text(10);
    CHECK_FALSE(text.ok);
  }
}
