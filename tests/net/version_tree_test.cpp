// SPDX-License-Identifier: Apache-2.0
#include "net/version_tree.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>
#include <map>
#include <numeric>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using net::Version;

namespace {

struct TestTreeNodes {
  std::vector<net::TreeNode>& all;
  net::TreeNode& operator()(std::uint32_t slot) const { return all[slot]; }
};
using TestTree = net::VersionTree<TestTreeNodes>;

/// A tree over some slots beside a std::map from version to slot.
class TreeBesideMap {
 public:
  explicit TreeBesideMap(std::uint32_t slots) : nodes_(slots), free_(slots) {
    std::iota(free_.begin(), free_.end(), 0U);
  }
  [[nodiscard]] bool has(Version version) const { return plain_.contains(version); }
  [[nodiscard]] bool is_full() const { return free_.empty(); }
  [[nodiscard]] std::size_t size() const { return plain_.size(); }
  [[nodiscard]] Version nth(std::size_t n) const {
    return std::next(plain_.begin(), static_cast<std::ptrdiff_t>(n))->first;
  }

  void insert(Version version) {
    const std::uint32_t slot = free_.back();
    free_.pop_back();
    nodes_[slot] = {version, 7, 7};  // what its last user left
    TestTree::insert(access_, root_, slot);
    plain_[version] = slot;
  }
  void erase(Version version) {
    const std::uint32_t slot = TestTree::erase(access_, root_, version);
    REQUIRE(slot == plain_.at(version));
    free_.push_back(slot);
    plain_.erase(version);
  }
  void erase_what_is_not_there(Version version) {
    REQUIRE(TestTree::erase(access_, root_, version) == TestTree::kNone);
  }
  void check_first_after(Version version) const {
    const auto next = plain_.upper_bound(version);
    const std::uint32_t expected = next == plain_.end() ? TestTree::kNone : next->second;
    REQUIRE(TestTree::first_after(access_, root_, version) == expected);
  }
  /// One after the other, all are there.
  void check_all() const {
    std::size_t walked = 0;
    Version at = 0;
    for (const auto& [version, slot] : plain_) {
      REQUIRE(TestTree::first_after(access_, root_, at) == slot);
      REQUIRE(nodes_[slot].version == version);
      at = version;
      ++walked;
    }
    REQUIRE(TestTree::first_after(access_, root_, at) == TestTree::kNone);
    REQUIRE(walked == plain_.size());
  }
  [[nodiscard]] std::size_t depth() const { return depth_below(root_); }
  /// The versions from the root down, left before right: the tree itself, wherever its nodes lie.
  [[nodiscard]] std::vector<Version> shape() const {
    std::vector<Version> versions;
    add_shape(root_, versions);
    return versions;
  }

 private:
  [[nodiscard]] std::size_t depth_below(std::uint32_t at) const {
    if (at == TestTree::kNone) return 0;
    return 1 + std::max(depth_below(nodes_[at].left), depth_below(nodes_[at].right));
  }
  void add_shape(std::uint32_t at, std::vector<Version>& versions) const {
    if (at == TestTree::kNone) return versions.push_back(0);
    versions.push_back(nodes_[at].version);
    add_shape(nodes_[at].left, versions);
    add_shape(nodes_[at].right, versions);
  }

  std::vector<net::TreeNode> nodes_;
  mutable TestTreeNodes access_{nodes_};
  std::uint32_t root_ = TestTree::kNone;
  std::vector<std::uint32_t> free_;
  std::map<Version, std::uint32_t> plain_;
};

enum class TreeOrder { ascending, descending, random };

std::vector<Version> versions_in(TreeOrder order, std::uint32_t count) {
  std::vector<Version> versions(count);
  std::iota(versions.begin(), versions.end(), Version{1});
  if (order == TreeOrder::descending) std::reverse(versions.begin(), versions.end());
  if (order == TreeOrder::random) {
    tests::Random random(5);
    for (std::uint32_t i = count; i > 1; --i) std::swap(versions[i - 1], versions[random.below(i)]);
  }
  return versions;
}

}  // namespace

TEST_CASE("a tree of versions does what std::map does in thousands of random steps", "[net]") {
  for (const std::uint32_t end : {8U, 300U, 5000U}) {
    INFO("versions below " << end);
    tests::Random random(end);
    TreeBesideMap tree(end / 2 + 1);
    tree.check_all();
    for (int step = 0; step < 20000; ++step) {
      const Version version = 1 + random.below(end);
      if (random.below(100) < 60) {
        if (!tree.has(version) && !tree.is_full()) tree.insert(version);
      } else if (tree.has(version)) {
        tree.erase(version);
      } else {
        tree.erase_what_is_not_there(version);
      }
      tree.check_first_after(random.below(end + 2));
    }
    tree.check_all();
    while (tree.size() > 0) tree.erase(tree.nth(random.below(static_cast<std::uint32_t>(tree.size()))));
    tree.check_all();
  }
}

TEST_CASE("a tree of versions stays flat and is the same whatever order they come in", "[net]") {
  constexpr std::uint32_t kCount = 10000;
  std::vector<Version> shape;
  for (const TreeOrder order : {TreeOrder::ascending, TreeOrder::descending, TreeOrder::random}) {
    TreeBesideMap tree(kCount);
    for (const Version version : versions_in(order, kCount)) tree.insert(version);
    tree.check_all();
    CHECK(tree.depth() < 50);  // 2 ln n on the average, twice that never
    if (shape.empty()) shape = tree.shape();
    CHECK(tree.shape() == shape);
  }
}

TEST_CASE("versions that went again leave no trace in the tree", "[net]") {
  tests::Random random(9);
  TreeBesideMap tree(400), untouched(400);
  for (Version version = 1; version <= 200; ++version) {
    tree.insert(version * 3);
    untouched.insert(version * 3);
  }
  for (int round = 0; round < 20; ++round) {
    std::vector<Version> guests;
    for (int i = 0; i < 150; ++i) {
      const Version guest = random.below(700);
      if (guest == 0 || tree.has(guest)) continue;
      tree.insert(guest);
      guests.push_back(guest);
    }
    for (const Version guest : guests) tree.erase(guest);
    REQUIRE(tree.shape() == untouched.shape());
  }
}

TEST_CASE("versions may be as high as numbers go", "[net]") {
  TreeBesideMap tree(8);
  const Version last = ~Version{0};
  for (const Version version : {last, Version{1}, last - 1, Version{1} << 48, Version{1} << 63}) tree.insert(version);
  tree.check_all();
  tree.check_first_after(last);
  tree.check_first_after(last - 1);
  tree.erase(last);
  tree.check_all();
}
