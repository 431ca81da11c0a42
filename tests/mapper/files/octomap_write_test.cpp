// SPDX-License-Identifier: Apache-2.0
// What we write is read by the real liboctomap, voxel by voxel.
#include "mapper/files/octomap_write.hpp"

#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <catch2/catch.hpp>
#include <sstream>

#include "mapper/files/octomap_format.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

std::istringstream stream_of(const Bytes& bytes) { return std::istringstream(std::string(bytes.begin(), bytes.end())); }

octomap::OcTreeKey key_of(MCode code) {
  const VoxelIndex v = decode(code);
  return {static_cast<octomap::key_type>(v.x), static_cast<octomap::key_type>(v.y),
          static_cast<octomap::key_type>(v.z)};
}

/// Calls `check(code, value)` for every voxel of every known block, the unknown ones too.
template <typename Check>
void for_each_voxel(const VoxelMap& map, Check check) {
  BlockValues values;
  for (const BlockKey key : map.sorted_keys()) {
    map.read_stored_block(key, values);
    for (std::size_t i = 0; i < values.size(); ++i) check((key << kBlockShift) | i, values[i]);
  }
}

/// Number of voxels inside of the tree's leaves.
template <typename Tree>
std::uint64_t voxels_in(const Tree& tree) {
  std::uint64_t voxels = 0;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it)
    voxels += std::uint64_t{1} << (3 * (16 - it.getDepth()));
  return voxels;
}

template <typename Tree>
std::unique_ptr<Tree> read_full(const Bytes& bytes) {
  auto stream = stream_of(bytes);
  std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(stream));
  REQUIRE(any);
  auto* tree = dynamic_cast<Tree*>(any.get());
  REQUIRE(tree != nullptr);
  any.release();
  return std::unique_ptr<Tree>(tree);
}

}  // namespace

TEST_CASE("liboctomap finds every level and colour of our .ot") {
  const auto map = tests::random_map(21, 300);
  const auto tree = read_full<octomap::ColorOcTree>(encode_octomap_full(*map));
  CHECK(tree->getResolution() == Approx(0.05));
  CHECK(voxels_in(*tree) == map->counts().known());
  std::uint64_t wrong = 0;
  for_each_voxel(*map, [&](MCode code, Rgbo value) {
    const octomap::ColorOcTreeNode* node = tree->search(key_of(code));
    if (state_of(value) == State::unknown) {
      wrong += node != nullptr ? 1 : 0;
      return;
    }
    if (node == nullptr || node->getLogOdds() != log_odds_of(level_of(value))) {
      ++wrong;
      return;
    }
    const auto c = node->getColor();
    const Rgbo expected = (value & kHasColourBit) != 0 ? value >> 8 : 0xFFFFFFU;
    wrong += ((static_cast<Rgbo>(c.r) << 16) | (static_cast<Rgbo>(c.g) << 8) | c.b) != expected ? 1 : 0;
  });
  CHECK(wrong == 0);
}

TEST_CASE("liboctomap agrees on what our inner nodes say") {
  const auto map = tests::random_map(22, 200);
  const Bytes bytes = encode_octomap_full(*map);
  const auto tree = read_full<octomap::ColorOcTree>(bytes);
  const auto recomputed = read_full<octomap::ColorOcTree>(bytes);
  recomputed->updateInnerOccupancy();
  auto a = tree->begin_tree();
  auto b = recomputed->begin_tree();
  std::uint64_t wrong = 0;
  for (; a != tree->end_tree() && b != recomputed->end_tree(); ++a, ++b) {
    const auto& ours = *a;
    const auto& theirs = *b;
    wrong += ours.getLogOdds() != theirs.getLogOdds() || !(ours.getColor() == theirs.getColor()) ? 1 : 0;
  }
  CHECK(a == tree->end_tree());
  CHECK(b == recomputed->end_tree());
  CHECK(wrong == 0);
}

TEST_CASE("Maps without colour become a plain OcTree with pruned leaves") {
  const auto map = tests::random_map(23, 300, 0.02F, false);
  const Bytes bytes = encode_octomap_full(*map);
  const auto tree = read_full<octomap::OcTree>(bytes);
  CHECK(voxels_in(*tree) == map->counts().known());
  const std::size_t nodes = tree->size();
  tree->prune();
  CHECK(tree->size() == nodes);  // nothing was left to prune
  std::uint64_t wrong = 0;
  for_each_voxel(*map, [&](MCode code, Rgbo value) {
    const octomap::OcTreeNode* node = tree->search(key_of(code));
    const bool known = state_of(value) != State::unknown;
    wrong += known != (node != nullptr) || (known && node->getLogOdds() != log_odds_of(level_of(value))) ? 1 : 0;
  });
  CHECK(wrong == 0);
}

TEST_CASE("Equal blocks are pruned above block size") {
  VoxelMap map(Grid{0.05F}, {16, 16, 16});
  BlockValues values;
  values.fill(0);
  for (BlockKey key = 64; key < 72; ++key) REQUIRE(map.write_block(key, values));
  const auto tree = read_full<octomap::OcTree>(encode_octomap_full(map));
  CHECK(tree->getNumLeafNodes() == 1);
  CHECK(tree->begin_leafs().getDepth() == 12);
}

TEST_CASE("liboctomap finds every state of our .bt") {
  const auto map = tests::random_map(24, 300);
  octomap::OcTree tree(0.1);
  auto stream = stream_of(encode_octomap_binary(*map));
  REQUIRE(tree.readBinary(stream));
  CHECK(tree.getResolution() == Approx(0.05));
  CHECK(voxels_in(tree) == map->counts().known());
  std::uint64_t wrong = 0;
  for_each_voxel(*map, [&](MCode code, Rgbo value) {
    const octomap::OcTreeNode* node = tree.search(key_of(code));
    const bool known = state_of(value) != State::unknown;
    wrong += known != (node != nullptr) || (known && tree.isNodeOccupied(node) != (state_of(value) == State::occupied))
                 ? 1
                 : 0;
  });
  CHECK(wrong == 0);
}

TEST_CASE("Voxel centres stand where liboctomap has them") {
  VoxelMap map(Grid{0.05F}, {16, 16, 16});
  const VoxelIndex v{32794, 32808, 32759};
  BlockValues values;
  values.fill(kUnknownRgbo);
  values[encode(v) & kPlaceMask] = 32;
  REQUIRE(map.write_block(block_of(v), values));
  const auto tree = read_full<octomap::OcTree>(encode_octomap_full(map));
  REQUIRE(tree->getNumLeafNodes() == 1);
  const auto it = tree->begin_leafs();
  const auto centre = map.grid().centre_m(v);
  CHECK(it.getX() == Approx(centre[0]));
  CHECK(it.getY() == Approx(centre[1]));
  CHECK(it.getZ() == Approx(centre[2]));
}

TEST_CASE("An empty map is an empty tree") {
  const VoxelMap map(Grid{0.05F}, {16, 16, 16});
  CHECK(read_full<octomap::OcTree>(encode_octomap_full(map))->size() == 0);
  octomap::OcTree tree(0.1);
  auto stream = stream_of(encode_octomap_binary(map));
  CHECK(tree.readBinary(stream));
  CHECK(tree.size() == 0);
}
