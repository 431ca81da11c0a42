// SPDX-License-Identifier: Apache-2.0
// The book of the slots from a disk that returns anything: it is refused, or it is a book that starts something
// sensible and that goes through its record unchanged. A right checksum is put under every other input, or none would
// get through.
#include <sodium.h>

#include <algorithm>
#include <cstdlib>

#include "hal/boot/slot_record.hpp"

namespace {

void look_at(std::span<const std::uint8_t> bytes) {
  using namespace g3d::hal;
  SlotRecord record;
  if (decode_slot_record(bytes, record) != SlotRecordFault::none) return;
  const SlotRecordBytes again = encode_slot_record(record);
  if (!std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) std::abort();
  for (int start = 0; start < 8; ++start) {
    const auto plan = plan_start(record.book);
    if (!plan) {
      for (const SlotEntry& entry : record.book.entries) {
        if (entry.condition != SlotCondition::empty) std::abort();
      }
      return;
    }
    if (record.book[plan->slot].condition == SlotCondition::empty) std::abort();
    record.book = plan->book;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  look_at({data, size_bytes});
  SlotRecordBytes bytes = encode_slot_record({});
  std::copy_n(data, std::min<std::size_t>(size_bytes, 136), bytes.begin() + 8);
  crypto_generichash(&bytes[144], 32, bytes.data(), 144, nullptr, 0);
  look_at(bytes);
  return 0;
}
