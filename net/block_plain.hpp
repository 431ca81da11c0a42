// SPDX-License-Identifier: Apache-2.0
// Codings of a part of a block that expect nothing: what made-up, random or nearly uniform blocks are shortest in, and
// what bounds the length of all others.
//
//   level                     one byte 0..32: all voxels have this level and no colour
//   33, codes                 raw: every voxel's code
//   34, count, codes, places  palette: 2..16 codes, then per voxel which one, in 1, 2 or 4 bits, lowest bits first
//   35, (length - 1, code)*   runs; lengths as LEB128
//
// Voxels are in order of M & 511. A code is a byte, the level with kHasColourBit, and R, G, B if it has that bit.
// Decoders check everything before they write: levels, that only what is occupied has a colour, that bytes and voxels
// end together. What they write on failure is unspecified. No allocation; one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "mapper/files/bytes.hpp"
#include "net/block_grid.hpp"

namespace g3d::net {

using mapper::ByteSpan;

inline constexpr std::uint8_t kRawByte = 33;
inline constexpr std::uint8_t kPaletteByte = 34;
inline constexpr std::uint8_t kRunsByte = 35;
inline constexpr std::size_t kMaxPalette = 16;

/// The most that a part ever takes, since raw is always possible.
[[nodiscard]] constexpr std::size_t max_bytes_of(Part part) { return 1 + 4 * places_of(part).count(); }

enum class UnpackError : std::uint8_t {
  none,
  empty,           ///< no bytes at all
  truncated,       ///< ends before all voxels are told
  trailing_bytes,  ///< goes on after all voxels are told
  bad_level,       ///< above 32
  bad_colour,      ///< of a voxel that is not occupied, or spare bits
  bad_palette,     ///< a count outside of 2..16, or a place outside of the palette
  bad_run,         ///< longer than the part
  wrong_end,       ///< entropy-coded bytes that no encoder would end so
};
[[nodiscard]] const char* to_string(UnpackError error);

/// What can be told: levels at most 32, colour only where occupied, RGB zero where there is none.
[[nodiscard]] mapper::Rgbo tellable(mapper::Rgbo code);

/// Writes the shortest of these codings if it is shorter than `shorter_than`; values are tellable. Returns its length,
/// or 0. `out` holds max_bytes_of().
[[nodiscard]] std::size_t pack_plain(const mapper::BlockValues& values, PlaceRange places, std::size_t shorter_than,
                                     std::span<std::uint8_t> out);

/// `bytes` begin with a byte below 36.
[[nodiscard]] UnpackError unpack_plain(ByteSpan bytes, PlaceRange places, mapper::BlockValues& out);

}  // namespace g3d::net
