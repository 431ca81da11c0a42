// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/block_codec.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cassert>

#include "mapper/files/level_codec.hpp"

namespace g3d::mapper {
namespace {

using hal::Error;
using hal::Reason;

enum StreamId : std::size_t {
  kKeys,
  kKinds,
  kHasColour,
  kGreen,
  kRedMinusGreen,
  kBlueMinusGreen,
  kFirstLevels,
  kStreamCount = kFirstLevels + kLevelStreams,
};
constexpr std::uint8_t kDense = 64;  ///< kinds 0..32: uniform blocks of that level
constexpr std::size_t kMaxStreamBytes = std::size_t{kMaxGroupBlocks} * kBlockVoxels;

/// Level planes of the group's blocks so far, to find the three below a block.
class PlaneIndex {
 public:
  void clear() { entries_.clear(); }
  void add(BlockKey key, const LevelPlane& plane) { entries_.push_back({key, &plane}); }
  [[nodiscard]] LowerPlanes below(BlockKey key) const {
    const VoxelIndex v = block_origin(key);
    return {find({v.x - kBlockSide_cells, v.y, v.z}), find({v.x, v.y - kBlockSide_cells, v.z}),
            find({v.x, v.y, v.z - kBlockSide_cells})};
  }

 private:
  struct Entry {
    BlockKey key;
    const LevelPlane* plane;
  };
  [[nodiscard]] const LevelPlane* find(const VoxelIndex& v) const {
    if (is_inside_grid(v)) {
      const BlockKey key = block_of(v);
      const auto it = std::lower_bound(entries_.begin(), entries_.end(), key,
                                       [](const Entry& entry, BlockKey wanted) { return entry.key < wanted; });
      if (it != entries_.end() && it->key == key) return it->plane;
    }
    return &constant_plane(kUnknownLevel);
  }
  std::vector<Entry> entries_;
};

struct Colour {
  std::uint8_t r = 0, g = 0, b = 0;
};

std::uint8_t byte_of(int value) { return static_cast<std::uint8_t>(value & 0xFF); }

}  // namespace

struct BlockEncoder::Work {
  int zstd_level;
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> zstd{ZSTD_createCCtx(), &ZSTD_freeCCtx};
  Bytes keys, kinds, has_colour, green, red_minus_green, blue_minus_green;
  LevelStreams levels;
  std::vector<LevelPlane> planes;
  PlaneIndex index;
  Bytes out;

  void clear() {
    for (Bytes* stream : {&keys, &kinds, &has_colour, &green, &red_minus_green, &blue_minus_green}) stream->clear();
    for (Bytes& stream : levels) stream.clear();
    planes.clear();
    index.clear();
    out.clear();
  }

  void add_colours(const BlockValues& values, bool& last_flag, Colour& last) {
    for (const Rgbo value : values) {
      if (state_of(value) != State::occupied) continue;
      const bool flag = (value & kHasColourBit) != 0;
      has_colour.push_back(flag == last_flag ? 0 : 1);
      last_flag = flag;
      if (!flag) continue;
      const Colour c{byte_of(static_cast<int>(value >> 24)), byte_of(static_cast<int>(value >> 16)),
                     byte_of(static_cast<int>(value >> 8))};
      green.push_back(byte_of(c.g - last.g));
      red_minus_green.push_back(byte_of((c.r - c.g) - (last.r - last.g)));
      blue_minus_green.push_back(byte_of((c.b - c.g) - (last.b - last.g)));
      last = c;
    }
  }

  void pack() {
    const std::size_t table = out.size();
    out.resize(table + kStreamCount * 8);
    for (std::size_t id = 0; id < kStreamCount; ++id) {
      const Bytes& raw = stream(id);
      std::size_t packed = 0;
      if (!raw.empty()) {
        const std::size_t at = out.size();
        out.resize(at + ZSTD_compressBound(raw.size()));
        packed = ZSTD_compressCCtx(zstd.get(), out.data() + at, out.size() - at, raw.data(), raw.size(), zstd_level);
        assert(!ZSTD_isError(packed) && "the bound is large enough and the level valid");
        out.resize(at + packed);
      }
      const std::array<std::uint32_t, 2> sizes{static_cast<std::uint32_t>(raw.size()),
                                               static_cast<std::uint32_t>(packed)};
      std::memcpy(out.data() + table + id * 8, sizes.data(), 8);
    }
  }

  [[nodiscard]] const Bytes& stream(std::size_t id) const {
    const std::array<const Bytes*, kFirstLevels> first{&keys,  &kinds,           &has_colour,
                                                       &green, &red_minus_green, &blue_minus_green};
    return id < kFirstLevels ? *first[id] : levels[id - kFirstLevels];
  }
};

BlockEncoder::BlockEncoder(int zstd_level) : work_(std::make_unique<Work>()) {
  work_->zstd_level = std::clamp(zstd_level, 1, 19);
}
BlockEncoder::~BlockEncoder() = default;

const Bytes& BlockEncoder::encode(std::span<const BlockKey> keys, const VoxelMap& map) {
  assert(keys.size() <= kMaxGroupBlocks);
  Work& w = *work_;
  w.clear();
  w.planes.reserve(keys.size());  // planes are pointed to: they must not move
  BlockKey next_key = 0;
  bool last_flag = false;
  Colour last_colour;
  BlockValues values;
  for (const BlockKey key : keys) {
    assert(key >= next_key && "keys ascend");
    put_varint(w.keys, key - next_key);
    next_key = key + 1;
    const std::uint32_t slot = map.find(key);
    const bool is_dense = slot != kNoSlot && map.header(slot).plane != kNoSlot;
    if (!is_dense) {
      const std::uint8_t level = slot == kNoSlot ? kUnknownLevel : map.header(slot).uniform_level;
      w.kinds.push_back(level);
      w.index.add(key, constant_plane(level));
      continue;
    }
    w.kinds.push_back(kDense);
    map.read_stored_block(key, values);
    LevelPlane& plane = w.planes.emplace_back();
    for (std::size_t i = 0; i < values.size(); ++i) plane[i] = level_of(values[i]);
    encode_levels(plane, w.index.below(key), w.levels);
    w.index.add(key, plane);
    w.add_colours(values, last_flag, last_colour);
  }
  w.pack();
  return w.out;
}

struct BlockDecoder::Work {
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> zstd{ZSTD_createDCtx(), &ZSTD_freeDCtx};
  std::array<Bytes, kStreamCount> streams;
  std::vector<LevelPlane> planes;
  PlaneIndex index;
  std::vector<StoredBlock> blocks;

  hal::Result<void> unpack(ByteSpan bytes) {
    ByteReader in(bytes);
    std::array<std::array<std::uint32_t, 2>, kStreamCount> sizes;
    if (!in.take(sizes)) return Error{Reason::truncated, "the table of streams is cut off"};
    for (std::size_t id = 0; id < kStreamCount; ++id) {
      const auto [raw_bytes, packed_bytes] = sizes[id];
      ByteSpan packed;
      if (raw_bytes > kMaxStreamBytes)
        return Error{Reason::too_large, fmt::format("stream {} claims {} bytes", id, raw_bytes)};
      if (!in.take_bytes(packed_bytes, packed))
        return Error{Reason::truncated, fmt::format("stream {} is cut off", id)};
      streams[id].resize(raw_bytes);
      if (raw_bytes == 0 && packed_bytes == 0) continue;
      const std::size_t got =
          ZSTD_decompressDCtx(zstd.get(), streams[id].data(), raw_bytes, packed.data(), packed.size());
      if (ZSTD_isError(got) || got != raw_bytes) {
        return Error{Reason::malformed, fmt::format("stream {} does not decompress to its {} bytes", id, raw_bytes)};
      }
    }
    if (in.left() != 0) return Error{Reason::malformed, "bytes are left over after the last stream"};
    return {};
  }

  /// Colours of one dense block whose levels stand in `values`.
  struct ColourState {
    std::size_t flag_place = 0, colour_place = 0;
    bool flag = false;
    Colour colour;
  };
  [[nodiscard]] bool take_colours(ColourState& state, BlockValues& values) const {
    for (Rgbo& value : values) {
      if (state_of(value) != State::occupied) continue;
      if (state.flag_place >= streams[kHasColour].size()) return false;
      const std::uint8_t toggled = streams[kHasColour][state.flag_place++];
      if (toggled > 1) return false;
      state.flag = state.flag != (toggled == 1);
      if (!state.flag) continue;
      const std::size_t i = state.colour_place++;
      if (i >= streams[kGreen].size()) return false;  // the three are equally long: checked by decode()
      const Colour& last = state.colour;
      const std::uint8_t g = byte_of(last.g + streams[kGreen][i]);
      const std::uint8_t r = byte_of(last.r - last.g + streams[kRedMinusGreen][i] + g);
      const std::uint8_t b = byte_of(last.b - last.g + streams[kBlueMinusGreen][i] + g);
      state.colour = {r, g, b};
      value = make_rgbo(r, g, b, static_cast<std::uint8_t>(level_of(value) | kHasColourBit));
    }
    return true;
  }
};

BlockDecoder::BlockDecoder() : work_(std::make_unique<Work>()) {}
BlockDecoder::~BlockDecoder() = default;

hal::Result<std::span<const StoredBlock>> BlockDecoder::decode(ByteSpan bytes) {
  Work& w = *work_;
  if (const auto unpacked = w.unpack(bytes); !unpacked) return unpacked.error();
  const Bytes& kinds = w.streams[kKinds];
  const std::size_t colours = w.streams[kGreen].size();
  if (kinds.size() > kMaxGroupBlocks)
    return Error{Reason::too_large, fmt::format("{} blocks in one group", kinds.size())};
  if (w.streams[kRedMinusGreen].size() != colours || w.streams[kBlueMinusGreen].size() != colours) {
    return Error{Reason::malformed, "the three colour streams differ in length"};
  }
  w.planes.clear();
  w.planes.reserve(static_cast<std::size_t>(std::count(kinds.begin(), kinds.end(), kDense)));  // they must not move
  w.index.clear();
  w.blocks.resize(kinds.size());
  std::array<ByteSpan, kLevelStreams> level_streams;
  for (std::size_t i = 0; i < level_streams.size(); ++i) level_streams[i] = w.streams[kFirstLevels + i];
  LevelDecoder levels(level_streams);
  ByteReader keys(w.streams[kKeys]);
  Work::ColourState colour;
  BlockKey next_key = 0;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    std::uint64_t gap = 0;
    constexpr BlockKey kKeyEnd = BlockKey{1} << (3 * kAxisBits - kBlockShift);
    if (!keys.take_varint(gap) || gap >= kKeyEnd || next_key + gap >= kKeyEnd) {
      return Error{Reason::out_of_range, fmt::format("key of block {} is missing or too large", i)};
    }
    StoredBlock& block = w.blocks[i];
    block.key = next_key + gap;
    next_key = block.key + 1;
    if (kinds[i] <= kMaxLevel) {
      block.values.fill(kinds[i]);
      w.index.add(block.key, constant_plane(kinds[i]));
      continue;
    }
    if (kinds[i] != kDense) return Error{Reason::malformed, fmt::format("block {} is of unknown kind {}", i, kinds[i])};
    LevelPlane& plane = w.planes.emplace_back();
    if (!levels.decode(w.index.below(block.key), plane)) {
      return Error{Reason::malformed, fmt::format("levels of block {} are missing or above {}", i, kMaxLevel)};
    }
    w.index.add(block.key, plane);
    std::copy(plane.begin(), plane.end(), block.values.begin());
    if (!w.take_colours(colour, block.values)) {
      return Error{Reason::malformed, fmt::format("colours of block {} are missing or malformed", i)};
    }
  }
  if (keys.left() != 0 || !levels.at_end() || colour.flag_place != w.streams[kHasColour].size() ||
      colour.colour_place != colours) {
    return Error{Reason::malformed, "streams hold more than the blocks need"};
  }
  return std::span<const StoredBlock>(w.blocks);
}

}  // namespace g3d::mapper
