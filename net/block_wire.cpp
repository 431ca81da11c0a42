// SPDX-License-Identifier: Apache-2.0
#include "net/block_wire.hpp"

#include <algorithm>

namespace g3d::net {

using mapper::BlockValues;

struct BlockPacker::Work {
  BlockModels models;
  LevelGrid levels;
  TintGrid tints;
  BlockValues values;
  std::array<Buffer, 3> buffers;
};

BlockPacker::BlockPacker() : work_(std::make_unique<Work>()) {}
BlockPacker::~BlockPacker() = default;

ByteSpan BlockPacker::pack_into(Buffer& out, const BlockValues& values, Part part) {
  Work& w = *work_;
  const PlaceRange places = places_of(part);
  bool equal = true;
  for (std::size_t i = places.begin; i < places.end; ++i) {
    w.values[i] = tellable(values[i]);
    equal = equal && w.values[i] == w.values[places.begin];
  }
  std::size_t coded_bytes = 0;
  if (!equal || (w.values[places.begin] & mapper::kHasColourBit) != 0) {
    w.models.restart();
    w.levels.fill(kNoLevel);
    for (std::size_t i = places.begin; i < places.end; ++i) {
      w.levels[kGridOrder.grid[i]] = mapper::level_of(w.values[kGridOrder.block[i]]);
    }
    RangeEncoder coder;
    coder.open(out, kFirstCodedByte);
    LevelCoding(coder, w.models).run(w.levels, places);
    ColourCoding(coder, w.models).run(w.values, w.tints, places);
    coded_bytes = coder.finish();
  }
  Buffer& other = w.buffers[2];
  const std::size_t plain_bytes = pack_plain(w.values, places, coded_bytes == 0 ? out.size() + 1 : coded_bytes, other);
  if (plain_bytes == 0) return ByteSpan(out).first(coded_bytes);
  std::copy_n(other.begin(), plain_bytes, out.begin());
  return ByteSpan(out).first(plain_bytes);
}

ByteSpan BlockPacker::pack(const BlockValues& values, Part part) { return pack_into(work_->buffers[0], values, part); }

std::span<const PackedPart> BlockPacker::pack_within(const BlockValues& values, std::size_t limit_bytes) {
  parts_[0] = {Part::whole, pack_into(work_->buffers[0], values, Part::whole)};
  if (parts_[0].bytes.size() <= limit_bytes) return std::span(parts_).first(1);
  parts_[0] = {Part::low_half, pack_into(work_->buffers[0], values, Part::low_half)};
  parts_[1] = {Part::high_half, pack_into(work_->buffers[1], values, Part::high_half)};
  return parts_;
}

struct BlockUnpacker::Work {
  BlockModels models;
  LevelGrid levels;
  TintGrid tints;
  BlockValues values;
};

BlockUnpacker::BlockUnpacker() : work_(std::make_unique<Work>()) {}
BlockUnpacker::~BlockUnpacker() = default;

UnpackError BlockUnpacker::unpack(ByteSpan bytes, Part part, BlockValues& in_out) {
  if (bytes.empty()) return UnpackError::empty;
  Work& w = *work_;
  const PlaceRange places = places_of(part);
  if (bytes[0] < kFirstCodedByte) {
    if (const UnpackError error = unpack_plain(bytes, places, w.values); error != UnpackError::none) return error;
  } else {
    w.models.restart();
    w.levels.fill(kNoLevel);
    RangeDecoder coder;
    coder.open(bytes, kFirstCodedByte);
    LevelCoding(coder, w.models).run(w.levels, places);
    for (std::size_t i = places.begin; i < places.end; ++i)
      w.values[kGridOrder.block[i]] = w.levels[kGridOrder.grid[i]];
    ColourCoding(coder, w.models).run(w.values, w.tints, places);
    if (!coder.at_end()) return UnpackError::wrong_end;
  }
  std::copy(w.values.begin() + static_cast<std::ptrdiff_t>(places.begin),
            w.values.begin() + static_cast<std::ptrdiff_t>(places.end),
            in_out.begin() + static_cast<std::ptrdiff_t>(places.begin));
  return UnpackError::none;
}

}  // namespace g3d::net
