// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/octomap_read.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <new>

#include "hal/image/file_bytes.hpp"
#include "mapper/files/octomap_format.hpp"
#include "mapper/files/octomap_header.hpp"

namespace g3d::mapper {
namespace {

using hal::Error;
using hal::Reason;

/// A known cube of voxels: those with `code >> 3 (16 - depth)` equal.
struct Leaf {
  MCode first;  ///< lowest M-code
  int depth;    ///< 0..16
  Rgbo value;   ///< stored form
};

std::uint64_t blocks_of(const Leaf& leaf) {
  return leaf.depth >= kBlockDepth ? 1 : std::uint64_t{1} << (3 * (kBlockDepth - leaf.depth));
}
bool is_coloured(const Leaf& leaf) { return (leaf.value & kHasColourBit) != 0; }

/// Depth-first over the file's nodes. Stops at the first thing wrong and says what.
template <typename Visit>
class TreeReader {
 public:
  TreeReader(const OctomapHeader& header, ByteSpan data, Visit visit) : header_(header), in_(data), visit_(visit) {}

  [[nodiscard]] bool read() {
    if (header_.nodes == 0) return in_.left() == 0 || fail("bytes follow an empty tree");
    const bool good = header_.is_binary ? (++nodes_, read_binary(0, 0)) : read_full(0, 0);
    if (!good) return false;
    if (in_.left() != 0) return fail("bytes follow the tree");
    return nodes_ == header_.nodes || fail("the tree has another number of nodes than `size` says");
  }
  [[nodiscard]] const char* problem() const { return problem_; }
  [[nodiscard]] Reason reason() const { return reason_; }
  [[nodiscard]] std::size_t offset() const { return in_.offset(); }
  [[nodiscard]] std::uint64_t nodes() const { return nodes_; }

 private:
  [[nodiscard]] bool fail(const char* problem, Reason reason = Reason::malformed) {
    problem_ = problem;
    reason_ = reason;
    return false;
  }

  [[nodiscard]] static MCode child_code(MCode first, int depth, int child) {
    return first | (static_cast<MCode>(child) << (3 * (kAxisBits - depth - 1)));
  }

  [[nodiscard]] bool read_full(MCode first, int depth) {
    ++nodes_;
    float log_odds = 0;
    std::array<std::uint8_t, 3> rgb{255, 255, 255};
    std::uint8_t mask = 0;
    if (!in_.take(log_odds) || (header_.is_coloured && !in_.take(rgb)) || !in_.take(mask))
      return fail("the tree is cut off", Reason::truncated);
    if (!std::isfinite(log_odds)) return fail("a node's log-odds are not a number");
    if (mask == 0) {
      const std::uint8_t level = level_of_log_odds(log_odds);
      const bool coloured = level > kUnknownLevel && rgb != std::array<std::uint8_t, 3>{255, 255, 255};
      visit_(Leaf{first, depth, coloured ? make_rgbo(rgb[0], rgb[1], rgb[2], level) | kHasColourBit : Rgbo{level}});
      return true;
    }
    if (depth == kAxisBits) return fail("a node below voxel size");
    for (int child = 0; child < 8; ++child) {
      if ((mask >> child & 1) != 0 && !read_full(child_code(first, depth, child), depth + 1)) return false;
    }
    return true;
  }

  [[nodiscard]] bool read_binary(MCode first, int depth) {
    std::uint16_t bits = 0;
    if (!in_.take(bits)) return fail("the tree is cut off", Reason::truncated);
    if (depth == kAxisBits) return fail("a node below voxel size");
    for (int child = 0; child < 8; ++child) {
      const int code = bits >> (2 * child) & 3;
      if (code == 0) continue;
      ++nodes_;
      const MCode child_first = child_code(first, depth, child);
      if (code == 3) {
        if (!read_binary(child_first, depth + 1)) return false;
      } else {
        visit_(Leaf{child_first, depth + 1, code == 2 ? Rgbo{kMaxLevel} : Rgbo{0}});
      }
    }
    return true;
  }

  const OctomapHeader& header_;
  ByteReader in_;
  Visit visit_;
  std::uint64_t nodes_ = 0;
  const char* problem_ = "";
  Reason reason_ = Reason::malformed;
};

/// What a tree needs as a map. Leaves come in ascending order, so one look back is enough to see a new block or brick.
class Measure {
 public:
  void add(const Leaf& leaf) {
    ++(state_of(leaf.value) == State::occupied ? occupied_leaves : free_leaves);
    const std::uint64_t blocks = blocks_of(leaf);
    if (leaf.depth <= kBlockDepth) {
      blocks_ += blocks;
      planes_ += is_coloured(leaf) ? blocks : 0;
      bricks_ += is_coloured(leaf) ? blocks * kBricksPerBlock : 0;
      return;
    }
    if (leaf.first >> kBlockShift != last_block_) {
      ++blocks_;
      ++planes_;
    }
    if (is_coloured(leaf) && leaf.first / kBrickVoxels != last_brick_) {
      ++bricks_;
      last_brick_ = leaf.first / kBrickVoxels;
    }
    last_block_ = leaf.first >> kBlockShift;
  }
  [[nodiscard]] bool fits(std::size_t limit_bytes) const {
    return blocks_ <= limit_bytes / (sizeof(BlockHeader) + 16) && planes_ <= limit_bytes / sizeof(LevelPlane) &&
           bricks_ <= limit_bytes / sizeof(ColourBrick) && blocks_ < 0xFFFFFFFFU / 8 && bricks_ < 0xFFFFFFFFU;
  }
  [[nodiscard]] MapCapacity capacity() const {
    const auto at_least_one = [](std::uint64_t n) { return static_cast<std::uint32_t>(n == 0 ? 1 : n); };
    return {at_least_one(blocks_), at_least_one(planes_), at_least_one(bricks_)};
  }
  [[nodiscard]] std::uint64_t blocks() const { return blocks_; }

  std::uint64_t occupied_leaves = 0;
  std::uint64_t free_leaves = 0;

 private:
  std::uint64_t blocks_ = 0, planes_ = 0, bricks_ = 0;
  std::uint64_t last_block_ = ~std::uint64_t{0}, last_brick_ = ~std::uint64_t{0};
};

/// Collects the leaves of one block, then writes it.
class Fill {
 public:
  explicit Fill(VoxelMap& map) : map_(map) { values_.fill(kUnknownRgbo); }
  void add(const Leaf& leaf) {
    if (leaf.first >> kBlockShift != key_) flush();
    key_ = leaf.first >> kBlockShift;
    if (leaf.depth < kBlockDepth) {
      BlockValues values;
      values.fill(leaf.value);
      for (std::uint64_t i = 0; i < blocks_of(leaf); ++i) complete_ = map_.write_block(key_ + i, values) && complete_;
      key_ = VoxelMap::kNoKey;
      return;
    }
    const std::size_t count = std::size_t{1} << (3 * (kAxisBits - leaf.depth));
    std::fill_n(values_.begin() + static_cast<std::ptrdiff_t>(leaf.first & kPlaceMask), count, leaf.value);
  }
  void flush() {
    if (key_ != VoxelMap::kNoKey) complete_ = map_.write_block(key_, values_) && complete_;
    key_ = VoxelMap::kNoKey;
    values_.fill(kUnknownRgbo);
  }
  [[nodiscard]] bool complete() const { return complete_; }

 private:
  VoxelMap& map_;
  BlockValues values_{};
  BlockKey key_ = VoxelMap::kNoKey;
  bool complete_ = true;
};

}  // namespace

hal::Result<OctomapContents> decode_octomap(ByteSpan bytes, const std::string& name, const OctomapOptions& options) {
  const auto header = decode_octomap_header(bytes, name);
  if (!header) return header.error();
  const ByteSpan data = bytes.subspan(header.value().data_offset);
  const auto no_room = [&](std::uint64_t blocks) {
    return Error{
        Reason::no_capacity,
        fmt::format("{}: a tree of {} blocks does not fit into the memory allowed; allow more or use a coarser tree",
                    name, blocks)};
  };

  Measure measure;
  const auto measure_leaf = [&](const Leaf& leaf) { measure.add(leaf); };
  TreeReader<decltype(measure_leaf)> checker(header.value(), data, measure_leaf);
  if (!checker.read()) {
    return Error{checker.reason(), fmt::format("{}: byte {}: {}; take another copy of the file", name,
                                               header.value().data_offset + checker.offset(), checker.problem())};
  }
  if (!measure.fits(options.memory_limit_bytes)) return no_room(measure.blocks());

  OctomapContents contents;
  contents.tree_type = header.value().is_coloured ? "ColorOcTree" : "OcTree";
  contents.nodes = checker.nodes();
  contents.occupied_leaves = measure.occupied_leaves;
  contents.free_leaves = measure.free_leaves;
  try {
    contents.map =
        std::make_unique<VoxelMap>(Grid{static_cast<float>(header.value().resolution_m)}, measure.capacity());
  } catch (const std::bad_alloc&) {
    return no_room(measure.blocks());
  }
  Fill fill(*contents.map);
  const auto fill_leaf = [&](const Leaf& leaf) { fill.add(leaf); };
  TreeReader<decltype(fill_leaf)> reader(header.value(), data, fill_leaf);
  const bool again = reader.read();
  fill.flush();
  if (!again || !fill.complete()) return no_room(measure.blocks());
  return contents;
}

hal::Result<OctomapContents> read_octomap(const std::string& path, const OctomapOptions& options) {
  constexpr std::size_t kMaxFile_bytes = std::size_t{32} << 30;
  const auto bytes = hal::read_file(path, kMaxFile_bytes);
  if (!bytes) return bytes.error();
  return decode_octomap(bytes.value(), path, options);
}

}  // namespace g3d::mapper
