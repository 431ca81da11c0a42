// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/slot_record.hpp"

#include <sodium.h>

#include <catch2/catch.hpp>
#include <functional>

using namespace g3d::hal;

namespace {

SlotRecord full_record() {
  SlotRecord record;
  record.sequence = 0x0102030405060708;
  record.book.preferred = Slot::b;
  record.book.newest_good_release = 77;
  record.book[Slot::a] = {SlotCondition::good, 0, false, {77, 1 << 24, {}}};
  record.book[Slot::b] = {SlotCondition::untried, 2, true, {60, 5, {}}};
  record.book[Slot::a].image.digest.fill(0xAB);
  record.book[Slot::b].image.digest.fill(0xCD);
  return record;
}

/// Changed, and the checksum made good again.
SlotRecordBytes forged(const std::function<void(SlotRecordBytes&)>& change) {
  SlotRecordBytes bytes = encode_slot_record(full_record());
  change(bytes);
  crypto_generichash(&bytes[144], 32, bytes.data(), 144, nullptr, 0);
  return bytes;
}

}  // namespace

TEST_CASE("the slots' book goes through its record", "[slots]") {
  for (const SlotRecord& record : {SlotRecord{}, full_record()}) {
    SlotRecord read;
    REQUIRE(decode_slot_record(encode_slot_record(record), read) == SlotRecordFault::none);
    CHECK(read.sequence == record.sequence);
    CHECK(read.book == record.book);
  }
}

TEST_CASE("a record in which any bit is wrong, or that is cut anywhere, is refused and nothing is read", "[slots]") {
  const SlotRecordBytes whole = encode_slot_record(full_record());
  SlotRecord read;
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    SlotRecordBytes bytes = whole;
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
    REQUIRE(decode_slot_record(bytes, read) != SlotRecordFault::none);
  }
  for (std::size_t size = 0; size < whole.size(); ++size) {
    REQUIRE(decode_slot_record(std::span(whole).first(size), read) == SlotRecordFault::wrong_size);
    // Torn: the front is new, the rest is what was there.
    SlotRecordBytes torn{};
    std::copy_n(whole.begin(), size, torn.begin());
    const bool is_whole = size >= 176;  // what follows is zero in any record
    REQUIRE((decode_slot_record(torn, read) == SlotRecordFault::none) == is_whole);
  }
  CHECK(decode_slot_record(SlotRecordBytes{}, read) == SlotRecordFault::no_mark);
}

TEST_CASE("values that nobody has written are refused, checksum or not", "[slots]") {
  SlotRecord read;
  CHECK(decode_slot_record(forged([](auto&) {}), read) == SlotRecordFault::none);
  using Change = std::function<void(SlotRecordBytes&)>;
  const std::vector<Change> wrong{
      [](auto& b) { b[16] = 2; }, [](auto& b) { b[20] = 1; }, [](auto& b) { b[32] = 4; },  [](auto& b) { b[33] = 4; },
      [](auto& b) { b[34] = 2; }, [](auto& b) { b[36] = 1; }, [](auto& b) { b[88] = 99; }, [](auto& b) { b[95] = 1; },
  };
  for (const Change& change : wrong) CHECK(decode_slot_record(forged(change), read) == SlotRecordFault::bad_field);
  for (int i = 0; i < 5; ++i) CHECK(std::string(to_string(static_cast<SlotRecordFault>(i))) != "unknown");
}
