// SPDX-License-Identifier: Apache-2.0
// Records in order of version: a treap over the slots of a pool, its priorities made of the versions themselves, so
// that the same versions always make the same tree (Seidel and Aragon 1996). Insert, erase and "the first after" take
// time in the logarithm of how many there are, wherever they come in; nothing is allocated. One thread.
#pragma once

#include <cstdint>

#include "net/layer_id.hpp"

namespace g3d::net {

struct TreeNode {
  Version version = 0;
  std::uint32_t left = 0xFFFFFFFFU;
  std::uint32_t right = 0xFFFFFFFFU;
};

/// `Nodes`: nodes(slot) is the TreeNode of a slot.
template <typename Nodes>
class VersionTree {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  /// A version that is not in the tree.
  static void insert(Nodes& nodes, std::uint32_t& root, std::uint32_t slot) {
    TreeNode& added = nodes(slot);
    std::uint32_t* link = &root;
    while (*link != kNone && priority(nodes(*link).version) >= priority(added.version)) {
      TreeNode& here = nodes(*link);
      link = added.version < here.version ? &here.left : &here.right;
    }
    split(nodes, *link, added.version, added.left, added.right);
    *link = slot;
  }
  /// A version that is in the tree. Returns its slot.
  static std::uint32_t erase(Nodes& nodes, std::uint32_t& root, Version version) {
    std::uint32_t* link = &root;
    while (*link != kNone && nodes(*link).version != version) {
      TreeNode& here = nodes(*link);
      link = version < here.version ? &here.left : &here.right;
    }
    const std::uint32_t slot = *link;
    if (slot != kNone) *link = joined(nodes, nodes(slot).left, nodes(slot).right);
    return slot;
  }
  /// The lowest version above `version`, or kNone.
  [[nodiscard]] static std::uint32_t first_after(const Nodes& nodes, std::uint32_t root, Version version) {
    std::uint32_t best = kNone;
    for (std::uint32_t at = root; at != kNone;) {
      const TreeNode& here = nodes(at);
      if (here.version > version) {
        best = at;
        at = here.left;
      } else {
        at = here.right;
      }
    }
    return best;
  }

 private:
  [[nodiscard]] static std::uint64_t priority(Version version) { return mixed(version, 0x7265636F72647321ULL); }

  static void split(Nodes& nodes, std::uint32_t tree, Version at, std::uint32_t& below, std::uint32_t& above) {
    std::uint32_t* low = &below;
    std::uint32_t* high = &above;
    while (tree != kNone) {
      TreeNode& here = nodes(tree);
      if (here.version < at) {
        *low = tree;
        low = &here.right;
        tree = here.right;
      } else {
        *high = tree;
        high = &here.left;
        tree = here.left;
      }
    }
    *low = kNone;
    *high = kNone;
  }
  /// Everything in `low` is below everything in `high`.
  static std::uint32_t joined(Nodes& nodes, std::uint32_t low, std::uint32_t high) {
    std::uint32_t root = kNone;
    std::uint32_t* link = &root;
    while (low != kNone && high != kNone) {
      if (priority(nodes(low).version) >= priority(nodes(high).version)) {
        *link = low;
        link = &nodes(low).right;
        low = *link;
      } else {
        *link = high;
        link = &nodes(high).left;
        high = *link;
      }
    }
    *link = low != kNone ? low : high;
    return root;
  }
};

}  // namespace g3d::net
