// SPDX-License-Identifier: Apache-2.0
// One block of 8x8x8 RGBO-codes <-> as few bytes as possible, to be sent in a datagram that others may never get: every
// block tells all of itself and needs no other.
//
// The first byte says which coding it is, and the shortest wins: below 36 one that expects nothing (block_plain.hpp:
// uniform, raw, palette, runs), from 36 on it belongs to an arithmetic code (range_coder.hpp) of levels and colours as
// trained models expect them (block_levels.hpp, block_colours.hpp). Which part of the block it is, the bytes do not
// say.
//
// What comes back: levels, colour flags, and RGB where there is a colour, exactly. RGB where there is none, and any
// colour of what is not occupied, is not told and comes back as zero; a map has no such codes.
// Bytes are checked to be a valid block, not to be the one that was sent: damaged ones may give another valid block. It
// is for the datagram to carry a checksum or a seal.
// A whole block may be longer than a datagram likes; a half never is (max_bytes_of()). Integers alone: the same bytes
// on every machine. Nothing is allocated after construction, and nothing thrown. One thread each.
#pragma once

#include <memory>

#include "net/block_colours.hpp"
#include "net/block_levels.hpp"
#include "net/block_plain.hpp"
#include "net/range_coder.hpp"

namespace g3d::net {

/// From this first byte on the bytes are an arithmetic code.
inline constexpr std::uint8_t kFirstCodedByte = 36;

inline constexpr std::size_t kDefaultBlockLimit_bytes = 1100;
static_assert(max_bytes_of(Part::low_half) <= kDefaultBlockLimit_bytes);

struct PackedPart {
  Part part;
  ByteSpan bytes;
};

class BlockPacker {
 public:
  BlockPacker();
  ~BlockPacker();
  BlockPacker(const BlockPacker&) = delete;
  BlockPacker& operator=(const BlockPacker&) = delete;

  /// Valid until the next call; at most max_bytes_of(part).
  [[nodiscard]] ByteSpan pack(const mapper::BlockValues& values, Part part);
  /// The whole block, or its two halves if that is longer than `limit_bytes`. Valid until the next call.
  [[nodiscard]] std::span<const PackedPart> pack_within(const mapper::BlockValues& values,
                                                        std::size_t limit_bytes = kDefaultBlockLimit_bytes);

 private:
  struct Work;
  using Buffer = std::array<std::uint8_t, max_bytes_of(Part::whole)>;
  ByteSpan pack_into(Buffer& out, const mapper::BlockValues& values, Part part);

  std::unique_ptr<Work> work_;
  std::array<PackedPart, 2> parts_{};
};

class BlockUnpacker {
 public:
  BlockUnpacker();
  ~BlockUnpacker();
  BlockUnpacker(const BlockUnpacker&) = delete;
  BlockUnpacker& operator=(const BlockUnpacker&) = delete;

  /// Writes the voxels of the part, and only if all of `bytes` is valid and used; else nothing.
  [[nodiscard]] UnpackError unpack(ByteSpan bytes, Part part, mapper::BlockValues& in_out);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace g3d::net
