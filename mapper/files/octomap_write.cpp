// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/octomap_write.hpp"

#include <fmt/format.h>

#include <span>
#include <string_view>

#include "hal/image/file_bytes.hpp"
#include "mapper/files/octomap_format.hpp"

namespace g3d::mapper {
namespace {

constexpr Rgbo kNoColour = 0xFFFFFF00U;  // OctoMap's white

/// What a node says of itself to its parent.
struct NodeSummary {
  bool exists = false;
  bool is_leaf = false;
  Rgbo value = kUnknownRgbo;  ///< R G B level; RGB white where there is no colour
};

/// The eight children of a node that all exist, are leaves and are equal make one leaf.
bool can_prune(const std::array<NodeSummary, 8>& children) {
  for (const NodeSummary& child : children) {
    if (!child.exists || !child.is_leaf || child.value != children[0].value) return false;
  }
  return true;
}

/// Level: maximum of the children. Colour: average over the children that have one (ColorOcTree::updateInnerOccupancy).
Rgbo inner_value(const std::array<NodeSummary, 8>& children) {
  std::uint8_t level = 0;
  std::array<std::uint32_t, 3> sum{};
  std::uint32_t coloured = 0;
  for (const NodeSummary& child : children) {
    if (!child.exists) continue;
    level = std::max(level, level_of(child.value));
    if ((child.value & 0xFFFFFF00U) == kNoColour) continue;
    ++coloured;
    for (std::size_t i = 0; i < 3; ++i) sum[i] += (child.value >> (24 - 8 * i)) & 0xFFU;
  }
  if (coloured == 0) return kNoColour | level;
  const auto mean = [&](std::size_t i) { return static_cast<std::uint8_t>(sum[i] / coloured); };
  return make_rgbo(mean(0), mean(1), mean(2), level);
}

/// Walks the octree depth first over ascending block keys. `Format` lays out the nodes: FullFormat or BinaryFormat.
template <typename Format>
class TreeWriter {
 public:
  TreeWriter(const VoxelMap& map, Bytes& out, Format format) : map_(map), out_(out), format_(format) {}

  NodeSummary write(int depth, std::span<const BlockKey> keys) {
    if (keys.empty()) return {};
    if (depth == kBlockDepth) return write_block(keys.front());
    return write_inner([&](int child) {
      const int shift = 3 * (kBlockDepth - depth - 1);
      const auto is_before = [&](BlockKey key) { return static_cast<int>((key >> shift) & 7U) <= child; };
      const auto end = std::partition_point(keys.begin(), keys.end(), is_before);
      const std::span<const BlockKey> mine(keys.begin(), end);
      keys = std::span<const BlockKey>(end, keys.end());
      return write(depth + 1, mine);
    });
  }
  [[nodiscard]] std::uint64_t node_count() const { return nodes_; }

 private:
  NodeSummary write_block(BlockKey key) {
    const BlockHeader& header = map_.header(map_.find(key));
    if (header.plane == kNoSlot) return write_leaf(kNoColour | header.uniform_level);
    map_.read_stored_block(key, values_);
    return write_part(0, kBlockVoxels);
  }
  NodeSummary write_part(std::size_t first, std::size_t count) {
    if (count == 1) {
      const Rgbo value = values_[first];
      if (state_of(value) == State::unknown) return {};
      return write_leaf((value & kHasColourBit) != 0 ? (value & ~Rgbo{kHasColourBit}) : kNoColour | level_of(value));
    }
    return write_inner(
        [&](int child) { return write_part(first + static_cast<std::size_t>(child) * count / 8, count / 8); });
  }
  NodeSummary write_leaf(Rgbo value) {
    ++nodes_;
    value = format_.simplified(value);
    format_.add_leaf(out_, value);
    return {true, true, value};
  }
  /// The node's own bytes stand before its children's but depend on them: reserved first, filled in afterwards.
  template <typename WriteChild>
  NodeSummary write_inner(WriteChild write_child) {
    const std::size_t begin = out_.size();
    const std::uint64_t nodes_before = nodes_++;
    format_.begin_inner(out_);
    std::array<NodeSummary, 8> children;
    bool any = false;
    for (int i = 0; i < 8; ++i) {
      children[static_cast<std::size_t>(i)] = write_child(i);
      any = any || children[static_cast<std::size_t>(i)].exists;
    }
    if (!any || can_prune(children)) {
      out_.resize(begin);
      nodes_ = nodes_before;
      return any ? write_leaf(children[0].value) : NodeSummary{};
    }
    const Rgbo value = inner_value(children);
    format_.finish_inner(out_, begin, value, children);
    return {true, false, value};
  }

  const VoxelMap& map_;
  Bytes& out_;
  Format format_;
  BlockValues values_{};
  std::uint64_t nodes_ = 0;
};

struct FullFormat {
  bool coloured;

  [[nodiscard]] Rgbo simplified(Rgbo value) const { return value; }
  void add_leaf(Bytes& out, Rgbo value) const {
    out.resize(out.size() + node_bytes());
    fill(out, out.size() - node_bytes(), value, 0);
  }
  void begin_inner(Bytes& out) const { out.resize(out.size() + node_bytes()); }
  void finish_inner(Bytes& out, std::size_t at, Rgbo value, const std::array<NodeSummary, 8>& children) const {
    unsigned mask = 0;
    for (std::size_t i = 0; i < 8; ++i) mask |= (children[i].exists ? 1U : 0U) << i;
    fill(out, at, value, static_cast<std::uint8_t>(mask));
  }

 private:
  [[nodiscard]] std::size_t node_bytes() const { return coloured ? 8 : 5; }
  void fill(Bytes& out, std::size_t at, Rgbo value, std::uint8_t mask) const {
    const float log_odds = log_odds_of(level_of(value));
    std::memcpy(out.data() + at, &log_odds, 4);
    at += 4;
    if (coloured) {
      for (int shift = 24; shift >= 8; shift -= 8) out[at++] = static_cast<std::uint8_t>(value >> shift);
    }
    out[at] = mask;
  }
};

struct BinaryFormat {
  [[nodiscard]] Rgbo simplified(Rgbo value) const { return state_of(value) == State::occupied ? kMaxLevel : 0; }
  void add_leaf(Bytes&, Rgbo) const {}  // a leaf stands in its parent's bits alone
  void begin_inner(Bytes& out) const { out.resize(out.size() + 2); }
  void finish_inner(Bytes& out, std::size_t at, Rgbo, const std::array<NodeSummary, 8>& children) const {
    std::uint16_t bits = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      const NodeSummary& child = children[i];
      const unsigned code = !child.exists                              ? 0U
                            : !child.is_leaf                           ? 3U
                            : state_of(child.value) == State::occupied ? 2U
                                                                       : 1U;
      bits = static_cast<std::uint16_t>(bits | (code << (2 * i)));
    }
    std::memcpy(out.data() + at, &bits, 2);
  }
};

template <typename Format>
Bytes encode_tree(const VoxelMap& map, Format format, std::string_view first_line, std::string_view tree_type) {
  const std::vector<BlockKey> keys = map.sorted_keys();
  Bytes tree;
  TreeWriter<Format> writer(map, tree, format);
  writer.write(0, keys);
  const std::string header = fmt::format(
      "{}\n# (feel free to add / change comments, but leave the first line as it is!)\n#\nid {}\nsize {}\nres "
      "{}\ndata\n",
      first_line, tree_type, writer.node_count(), map.grid().resolution_m);
  Bytes out;
  out.reserve(header.size() + tree.size());
  out.insert(out.end(), header.begin(), header.end());
  put_bytes(out, tree);
  return out;
}

}  // namespace

Bytes encode_octomap_full(const VoxelMap& map) {
  const bool coloured = map.counts().coloured > 0;
  return encode_tree(map, FullFormat{coloured}, "# Octomap OcTree file", coloured ? "ColorOcTree" : "OcTree");
}

Bytes encode_octomap_binary(const VoxelMap& map) {
  return encode_tree(map, BinaryFormat{}, "# Octomap OcTree binary file", "OcTree");
}

hal::Result<void> write_octomap(const VoxelMap& map, const std::string& path) {
  return hal::write_file_atomic(path, path.ends_with(".bt") ? encode_octomap_binary(map) : encode_octomap_full(map));
}

}  // namespace g3d::mapper
