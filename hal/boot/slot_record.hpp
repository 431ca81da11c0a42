// SPDX-License-Identifier: Apache-2.0
// The book of the slots as 512 bytes, one sector: what a disk writes as a whole or not at all, if it is a good one. A
// checksum tells when it is not. Little-endian:
//
//   0  "G3DSLOT1"    8  u64 sequence    16  u8 preferred    17  7 bytes 0    24  u64 newest_good_release
//   32 + 56 i  of slot i:  u8 condition, u8 starts, u8 may_go_back, 5 bytes 0, u64 release, u64 size_bytes, digest
//   144  BLAKE2b-256 of what stands before it    176  zeros
//
// Pure; any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/boot/slots.hpp"

namespace g3d::hal {

inline constexpr std::size_t kSlotRecord_bytes = 512;
using SlotRecordBytes = std::array<std::uint8_t, kSlotRecord_bytes>;

struct SlotRecord {
  std::uint64_t sequence = 0;  ///< the record with the larger one is the newer one
  SlotBook book;
};

[[nodiscard]] SlotRecordBytes encode_slot_record(const SlotRecord& record);

enum class SlotRecordFault : std::uint8_t {
  none,
  wrong_size,
  no_mark,       ///< something else, or never written
  bad_checksum,  ///< torn or rotten
  bad_field,     ///< a value that this version knows nothing of
};
[[nodiscard]] const char* to_string(SlotRecordFault fault);

/// `record` is written to only if the answer is `none`.
[[nodiscard]] SlotRecordFault decode_slot_record(std::span<const std::uint8_t> bytes, SlotRecord& record);

}  // namespace g3d::hal
