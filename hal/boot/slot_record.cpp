// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/slot_record.hpp"

#include <sodium.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace g3d::hal {
namespace {

static_assert(std::endian::native == std::endian::little, "the record is little-endian; all our targets are, too");

constexpr std::array<std::uint8_t, 8> kRecordMark{'G', '3', 'D', 'S', 'L', 'O', 'T', '1'};
constexpr std::size_t kEntries_at = 32;
constexpr std::size_t kEntry_bytes = 56;
constexpr std::size_t kChecksum_at = kEntries_at + kSlotCount * kEntry_bytes;
constexpr std::size_t kChecksum_bytes = 32;
constexpr std::size_t kRecordEnd = kChecksum_at + kChecksum_bytes;

void put_u64(std::uint8_t* at, std::uint64_t value) { std::memcpy(at, &value, sizeof value); }
std::uint64_t u64_at(const std::uint8_t* at) {
  std::uint64_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

bool are_zeros(std::span<const std::uint8_t> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte == 0; });
}

void put_entry(std::uint8_t* at, const SlotEntry& entry) {
  at[0] = static_cast<std::uint8_t>(entry.condition);
  at[1] = entry.starts;
  at[2] = entry.may_go_back ? 1 : 0;
  put_u64(at + 8, entry.image.release);
  put_u64(at + 16, entry.image.size_bytes);
  std::memcpy(at + 24, entry.image.digest.data(), entry.image.digest.size());
}

bool take_entry(const std::uint8_t* at, SlotEntry& entry) {
  if (at[0] > static_cast<std::uint8_t>(SlotCondition::bad) || at[1] > kMostFailedStarts || at[2] > 1 ||
      !are_zeros({at + 3, 5})) {
    return false;
  }
  entry.condition = static_cast<SlotCondition>(at[0]);
  entry.starts = at[1];
  entry.may_go_back = at[2] != 0;
  entry.image.release = u64_at(at + 8);
  entry.image.size_bytes = u64_at(at + 16);
  std::memcpy(entry.image.digest.data(), at + 24, entry.image.digest.size());
  return true;
}

std::array<std::uint8_t, kChecksum_bytes> checksum_of_record(const std::uint8_t* bytes) {
  std::array<std::uint8_t, kChecksum_bytes> checksum;
  crypto_generichash(checksum.data(), checksum.size(), bytes, kChecksum_at, nullptr, 0);
  return checksum;
}

}  // namespace

const char* to_string(SlotRecordFault fault) {
  switch (fault) {
    case SlotRecordFault::none:
      return "none";
    case SlotRecordFault::wrong_size:
      return "wrong size";
    case SlotRecordFault::no_mark:
      return "no mark";
    case SlotRecordFault::bad_checksum:
      return "bad checksum";
    case SlotRecordFault::bad_field:
      return "bad field";
  }
  return "unknown";
}

SlotRecordBytes encode_slot_record(const SlotRecord& record) {
  SlotRecordBytes bytes{};
  std::copy(kRecordMark.begin(), kRecordMark.end(), bytes.begin());
  put_u64(&bytes[8], record.sequence);
  bytes[16] = static_cast<std::uint8_t>(record.book.preferred);
  put_u64(&bytes[24], record.book.newest_good_release);
  for (std::size_t i = 0; i < kSlotCount; ++i)
    put_entry(&bytes[kEntries_at + i * kEntry_bytes], record.book.entries[i]);
  const auto checksum = checksum_of_record(bytes.data());
  std::copy(checksum.begin(), checksum.end(), bytes.begin() + kChecksum_at);
  return bytes;
}

SlotRecordFault decode_slot_record(std::span<const std::uint8_t> bytes, SlotRecord& record) {
  if (bytes.size() != kSlotRecord_bytes) return SlotRecordFault::wrong_size;
  if (!std::equal(kRecordMark.begin(), kRecordMark.end(), bytes.begin())) return SlotRecordFault::no_mark;
  const auto checksum = checksum_of_record(bytes.data());
  if (!std::equal(checksum.begin(), checksum.end(), bytes.begin() + kChecksum_at) ||
      !are_zeros(bytes.subspan(kRecordEnd))) {
    return SlotRecordFault::bad_checksum;
  }
  SlotRecord read;
  read.sequence = u64_at(&bytes[8]);
  if (bytes[16] > 1 || !are_zeros(bytes.subspan(17, 7))) return SlotRecordFault::bad_field;
  read.book.preferred = static_cast<Slot>(bytes[16]);
  read.book.newest_good_release = u64_at(&bytes[24]);
  for (std::size_t i = 0; i < kSlotCount; ++i) {
    if (!take_entry(&bytes[kEntries_at + i * kEntry_bytes], read.book.entries[i])) return SlotRecordFault::bad_field;
  }
  record = read;
  return SlotRecordFault::none;
}

}  // namespace g3d::hal
