// SPDX-License-Identifier: Apache-2.0
// What the real liboctomap writes is read by us, voxel by voxel; hostile files are refused.
#include "mapper/files/octomap_read.hpp"

#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "mapper/files/octomap_format.hpp"
#include "mapper/files/octomap_write.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

template <typename Tree>
Bytes written(const Tree& tree) {
  std::ostringstream out;
  REQUIRE(tree.write(out));
  const std::string text = out.str();
  return {text.begin(), text.end()};
}

Bytes file(const std::string& header, const Bytes& data) {
  Bytes bytes(header.begin(), header.end());
  put_bytes(bytes, data);
  return bytes;
}

/// A tree of clustered points with free rays, big pruned leaves included.
template <typename Tree>
void fill(Tree& tree, std::uint64_t seed) {
  tests::Random random(seed);
  for (int i = 0; i < 3000; ++i) {
    const octomap::point3d point(static_cast<float>(random.uniform(-2, 2)), static_cast<float>(random.uniform(-2, 2)),
                                 static_cast<float>(random.uniform(-1, 1)));
    tree.updateNode(point, random.below(3) != 0);
  }
  for (double x = 4.0; x < 7.2; x += tree.getResolution()) {
    for (double y = 0.0; y < 1.6; y += tree.getResolution()) {
      for (double z = 0.0; z < 1.6; z += tree.getResolution()) {
        tree.setNodeValue(
            octomap::point3d(static_cast<float>(x + 0.01), static_cast<float>(y + 0.01), static_cast<float>(z + 0.01)),
            x < 5.6 ? -2.0F : 3.5F);
      }
    }
  }
  tree.prune();
}

/// Voxels on which map and tree differ, over every leaf of the tree.
template <typename Tree, typename Same>
std::uint64_t differences(const VoxelMap& map, const Tree& tree, Same same) {
  std::uint64_t wrong = 0;
  std::uint64_t known = 0;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) {
    const int side = 1 << (16 - it.getDepth());
    const octomap::OcTreeKey low = it.getIndexKey();
    known += static_cast<std::uint64_t>(side) * side * side;
    for (int i = 0; i < side * side * side; ++i) {
      const VoxelIndex v{low[0] + i % side, low[1] + i / side % side, low[2] + i / side / side};
      wrong += same(map.at(v), *it) ? 0 : 1;
    }
  }
  return wrong + (known != map.counts().known() ? 1 : 0);
}

}  // namespace

TEST_CASE("An OcTree of liboctomap comes over with every level") {
  octomap::OcTree tree(0.1);
  fill(tree, 31);
  const auto read = decode_octomap(written(tree), "tree.ot");
  REQUIRE(read.ok());
  CHECK(read.value().tree_type == "OcTree");
  CHECK(read.value().nodes == tree.size());
  CHECK(read.value().map->grid().resolution_m == 0.1F);
  CHECK(read.value().map->counts().uniform_blocks > 0);
  CHECK(differences(*read.value().map, tree, [](Rgbo ours, const octomap::OcTreeNode& theirs) {
          return level_of(ours) == level_of_log_odds(theirs.getLogOdds());
        }) == 0);
}

TEST_CASE("A ColorOcTree of liboctomap comes over with its colours") {
  octomap::ColorOcTree tree(0.05);
  fill(tree, 32);
  tests::Random random(5);
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) {
    if (random.below(3) == 0) continue;
    it->setColor(static_cast<std::uint8_t>(random.below(255)), static_cast<std::uint8_t>(random.below(256)), 9);
  }
  tree.updateInnerOccupancy();
  const auto read = decode_octomap(written(tree), "tree.ot");
  REQUIRE(read.ok());
  CHECK(read.value().tree_type == "ColorOcTree");
  CHECK(read.value().map->counts().coloured > 0);
  CHECK(differences(*read.value().map, tree, [](Rgbo ours, const octomap::ColorOcTreeNode& theirs) {
          const auto c = theirs.getColor();
          const bool coloured = theirs.isColorSet() && state_of(ours) == State::occupied;
          return ours == make_rgbo(coloured ? c.r : 0, coloured ? c.g : 0, coloured ? c.b : 0,
                                   level_of_log_odds(theirs.getLogOdds()));
        }) == 0);
}

TEST_CASE("A binary tree of liboctomap comes over with every state") {
  octomap::OcTree tree(0.1);
  fill(tree, 33);
  tree.toMaxLikelihood();
  tree.prune();
  std::ostringstream out;
  REQUIRE(tree.writeBinaryConst(out));
  const std::string text = out.str();
  const auto read = decode_octomap(Bytes(text.begin(), text.end()), "tree.bt");
  REQUIRE(read.ok());
  CHECK(read.value().occupied_leaves + read.value().free_leaves == tree.getNumLeafNodes());
  CHECK(differences(*read.value().map, tree, [&](Rgbo ours, const octomap::OcTreeNode& theirs) {
          return state_of(ours) == (tree.isNodeOccupied(theirs) ? State::occupied : State::free);
        }) == 0);
}

TEST_CASE("Our own .ot comes back bit by bit") {
  const auto map = tests::random_map(34, 400);
  const auto read = decode_octomap(encode_octomap_full(*map), "own.ot");
  REQUIRE(read.ok());
  CHECK(map_hash(*map) == map_hash(*read.value().map));
}

TEST_CASE("A recorded building comes over whole") {
  const char* folder = std::getenv("G3D_DATA");
  const std::filesystem::path path =
      std::filesystem::path(folder != nullptr ? folder : "../shared/data") / "octomap/geb079.bt";
  if (!std::filesystem::exists(path)) return;
  std::ifstream in(path, std::ios::binary);
  const Bytes bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto read = decode_octomap(bytes, "geb079.bt");
  REQUIRE(read.ok());
  CHECK(read.value().nodes == 532566);
  CHECK(read.value().occupied_leaves == 143729);
  CHECK(read.value().free_leaves == 284415);
  octomap::OcTree tree(0.1);
  REQUIRE(tree.readBinary(path.string()));
  CHECK(differences(*read.value().map, tree, [&](Rgbo ours, const octomap::OcTreeNode& theirs) {
          return state_of(ours) == (tree.isNodeOccupied(theirs) ? State::occupied : State::free);
        }) == 0);
}

TEST_CASE("Log-odds of other programs are rounded, clamped and never unknown") {
  for (int level = 0; level <= 32; ++level) {
    if (level != 16) CHECK(level_of_log_odds(log_odds_of(static_cast<std::uint8_t>(level))) == level);
  }
  CHECK(level_of_log_odds(0.0F) == 17);  // octomap: 0 is not below the threshold
  CHECK(level_of_log_odds(-0.01F) == 15);
  CHECK(level_of_log_odds(1e30F) == 32);
  CHECK(level_of_log_odds(-1e30F) == 0);
}

TEST_CASE("A leaf as large as a city is refused before memory is taken") {
  const std::string header = "# Octomap OcTree file\nid OcTree\nsize 2\nres 0.05\ndata\n";
  Bytes data;
  put(data, 1.0F);
  put(data, std::uint8_t{1});  // root with one child ...
  put(data, 1.0F);
  put(data, std::uint8_t{0});  // ... that is a leaf of 32768^3 voxels
  const auto read = decode_octomap(file(header, data), "huge.ot");
  REQUIRE_FALSE(read.ok());
  CHECK(read.error().reason == hal::Reason::no_capacity);
}

TEST_CASE("Malformed OctoMap files are refused with place and remedy") {
  const std::string good = "# Octomap OcTree file\nid OcTree\nsize 1\nres 0.05\ndata\n";
  const auto reason = [](const std::string& header, const Bytes& data) {
    const auto read = decode_octomap(file(header, data), "bad.ot");
    REQUIRE_FALSE(read.ok());
    CHECK(read.error().text.find("bad.ot") == 0);
    return read.error().reason;
  };
  using hal::Reason;
  CHECK(reason("", {}) == Reason::malformed);
  CHECK(reason("# Something else\n", {}) == Reason::malformed);
  CHECK(reason("# Octomap OcTree file\nid OcTree\n", {}) == Reason::truncated);
  CHECK(reason("# Octomap OcTree file\nid OcTree\nsize 1\ndata\n", {}) == Reason::malformed);
  CHECK(reason("# Octomap OcTree file\nid OcTreeStamped\nsize 1\nres 1\ndata\n", {}) == Reason::unsupported);
  CHECK(reason("# Octomap OcTree file\nid OcTree\nsize -1\nres 1\ndata\n", {}) == Reason::malformed);
  CHECK(reason("# Octomap OcTree file\nid OcTree\nsize 1\nres nan\ndata\n", {}) == Reason::out_of_range);
  CHECK(reason("# Octomap OcTree file\nid OcTree\nsize 1\nres 1e9\ndata\n", {}) == Reason::out_of_range);
  CHECK(reason(good, {}) == Reason::truncated);
  Bytes nan;
  put(nan, std::uint32_t{0x7FC00000U});
  nan.push_back(0);
  CHECK(reason(good, nan) == Reason::malformed);
  Bytes chain;  // one child after the other, deeper than voxels are
  for (int i = 0; i < 30; ++i) {
    put(chain, 1.0F);
    chain.push_back(1);
  }
  CHECK(reason(good, chain) == Reason::malformed);
  CHECK(reason("# Octomap OcTree binary file\nid OcTree\nsize 99\nres 1\ndata\n", Bytes(64, 0xFF)) ==
        Reason::malformed);
}

TEST_CASE("Every cut and many a spoiled byte of an OctoMap file is survived") {
  const auto map = tests::random_map(35, 12);
  const Bytes good = encode_octomap_full(*map);
  OctomapOptions options;
  options.memory_limit_bytes = std::size_t{1} << 22;
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 50)
    CHECK_FALSE(decode_octomap(ByteSpan(good).first(size), "cut.ot", options).ok());
  tests::Random random(36);
  for (int i = 0; i < 300; ++i) {
    Bytes bad = good;
    bad[random.below(static_cast<std::uint32_t>(bad.size()))] ^= static_cast<std::uint8_t>(1U << random.below(8));
    (void)decode_octomap(bad, "spoiled.ot", options).ok();
  }
}
