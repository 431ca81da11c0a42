// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/kobuki_log.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/temp_folder.hpp"

namespace {

using namespace g3d::hal;
using Bytes = std::vector<std::uint8_t>;

Bytes two_records() {
  Bytes file;
  append_record(file, -5, Bytes{1, 2, 3});
  append_record(file, 1'000'000'000'000, Bytes{0xAA});
  return file;
}

TEST_CASE("records come back as they were written") {
  const auto log = KobukiLog::parse(two_records(), "kobuki.bin");
  REQUIRE(log.ok());
  CHECK(log.value().record_count() == 2);
  CHECK(log.value().torn_bytes() == 0);
  auto records = log.value().records();
  REQUIRE(records.peek());
  CHECK(records.peek()->t_ns == -5);
  CHECK(Bytes(records.peek()->bytes.begin(), records.peek()->bytes.end()) == Bytes{1, 2, 3});
  records.advance();
  REQUIRE(records.peek());
  CHECK(records.peek()->t_ns == 1'000'000'000'000);
  records.advance();
  CHECK_FALSE(records.peek());
  records.advance();
  CHECK_FALSE(records.peek());
}

TEST_CASE("the file is laid out as documented") {
  Bytes file;
  append_record(file, 0x0102030405060708, Bytes{0x55, 0x66});
  CHECK(file == Bytes{8, 7, 6, 5, 4, 3, 2, 1, 2, 0, 0x55, 0x66});
}

TEST_CASE("more bytes than a record holds become several") {
  Bytes file;
  append_record(file, 7, Bytes(150'000, 9));
  const auto log = KobukiLog::parse(file, "kobuki.bin");
  REQUIRE(log.ok());
  CHECK(log.value().record_count() == 3);
  std::size_t bytes = 0;
  for (auto records = log.value().records(); records.peek(); records.advance()) bytes += records.peek()->bytes.size();
  CHECK(bytes == 150'000);
  append_record(file, 8, {});
  CHECK(file.size() == 150'030);
}

TEST_CASE("a file that was cut anywhere gives its whole records") {
  const Bytes whole = two_records();
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    const auto log = KobukiLog::parse(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), "cut");
    CAPTURE(size);
    REQUIRE(log.ok());
    const std::size_t records = size == whole.size() ? 2 : size >= 13 ? 1 : 0;
    CHECK(log.value().record_count() == records);
    CHECK(log.value().torn_bytes() == size - (records == 2 ? whole.size() : 13 * records));
  }
}

TEST_CASE("what no recorder writes is refused, with its place") {
  Bytes backwards = two_records();
  append_record(backwards, 5, Bytes{1});
  const auto earlier = KobukiLog::parse(backwards, "kobuki.bin");
  REQUIRE_FALSE(earlier.ok());
  CHECK(earlier.error().reason == Reason::malformed);
  CHECK(earlier.error().text.find("kobuki.bin: byte 24:") == 0);

  Bytes empty_record = two_records();
  empty_record.insert(empty_record.end(), 10, 0x11);
  empty_record[empty_record.size() - 1] = empty_record[empty_record.size() - 2] = 0;
  const auto empty = KobukiLog::parse(empty_record, "x");
  REQUIRE_FALSE(empty.ok());

  Bytes far;
  append_record(far, std::numeric_limits<TimeNs>::max(), Bytes{1});
  const auto too_far = KobukiLog::parse(far, "x");
  REQUIRE_FALSE(too_far.ok());
  CHECK(too_far.error().reason == Reason::out_of_range);
}

TEST_CASE("a file is opened, and a missing one is an error") {
  const g3d::test::TempFolder folder;
  g3d::test::write_plain(folder / "kobuki.bin", two_records());
  const auto log = KobukiLog::open(folder / "kobuki.bin");
  REQUIRE(log.ok());
  CHECK(log.value().record_count() == 2);
  const auto missing = KobukiLog::open(folder / "none.bin");
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().reason == Reason::not_found);
}

}  // namespace
