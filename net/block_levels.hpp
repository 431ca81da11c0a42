// SPDX-License-Identifier: Apache-2.0
// Levels of a block through a coder that knows what to expect: each voxel is looked at from those before it, the 13
// that touch it.
//
// Most often all faces say the same, and one bit says that the voxel does, too. Otherwise: is it known; is it free or
// occupied; how far from saturation in steps of two (three bits, a tree); and is that off by one. The usual steps (hit
// 4, miss 2 from 16) keep to even levels but where 16 was stepped over, so the last costs next to nothing. Contexts are
// small numbers made of the neighbours; three of them look at each bit from different sides.
//
// Coder: RangeEncoder, RangeDecoder, or one that counts for training (tests/bench/block_train_bench.cpp). Whatever bits
// a decoder gives, the result is levels 0..32. One thread; nothing is allocated.
#pragma once

#include <algorithm>

#include "net/block_grid.hpp"
#include "net/block_models.hpp"
#include "net/level_classes.hpp"

namespace g3d::net {

using LevelGrid = std::array<std::uint8_t, kGridPlaces>;

/// The voxels before one: next to it in the same layer, and below (d).
struct Before {
  explicit Before(const std::uint8_t* at)
      : w(at[-1]),
        n(at[-kRow]),
        d(at[-kLayer]),
        nw(at[-kRow - 1]),
        ne(at[-kRow + 1]),
        dw(at[-kLayer - 1]),
        de(at[-kLayer + 1]),
        dn(at[-kLayer - kRow]),
        ds(at[-kLayer + kRow]),
        dnw(at[-kLayer - kRow - 1]),
        dne(at[-kLayer - kRow + 1]),
        dsw(at[-kLayer + kRow - 1]),
        dse(at[-kLayer + kRow + 1]) {}
  std::uint8_t w, n, d, nw, ne, dw, de, dn, ds, dnw, dne, dsw, dse;
};

template <typename Coder>
class LevelCoding {
 public:
  LevelCoding(Coder& coder, BlockModels& models) : coder_(coder), models_(models) {}

  /// Encoding reads `grid`, decoding fills it in. Places that are not of the part are kNoLevel.
  void run(LevelGrid& grid, PlaceRange places) {
    for (std::size_t i = places.begin; i < places.end; ++i) {
      const std::size_t place = kGridOrder.grid[i];
      grid[place] = code(grid.data() + place);
    }
  }

 private:
  static std::size_t same(std::uint8_t a, std::uint8_t b) { return a == b ? 1 : 0; }

  std::uint8_t code(const std::uint8_t* at) {
    const Before b(at);
    const std::uint8_t level = *at;
    const std::uint8_t guess = b.w != kNoLevel ? b.w : b.n != kNoLevel ? b.n : b.d;
    const bool agree = guess != kNoLevel && (b.n == guess || b.n == kNoLevel) && (b.d == guess || b.d == kNoLevel);
    if (agree) {
      const std::size_t like = same(b.nw, guess) + same(b.ne, guess) + same(b.dw, guess) + same(b.de, guess) +
                               same(b.dn, guess) + same(b.ds, guess);
      const std::size_t lone = same(b.w, kNoLevel) | same(b.n, kNoLevel) | same(b.d, kNoLevel);
      if (coder_.code(models_.same(guess, like, lone), level == guess)) return guess;
    }
    if (!code_known(b, level != mapper::kUnknownLevel)) return mapper::kUnknownLevel;
    const std::size_t sort = code_sort(b, level > mapper::kUnknownLevel) ? 1 : 0;
    const std::size_t steps = code_steps(b, sort, kLevelClasses.steps[level]);
    const auto even = static_cast<std::uint8_t>(sort == 1 ? mapper::kMaxLevel - 2 * steps : 2 * steps);
    const auto uneven = static_cast<std::uint8_t>(sort == 1 ? even - 1 : even + 1);
    const std::size_t around = ((b.w | b.n | b.d) & 1U) | (same(b.w, even) | same(b.n, even) | same(b.d, even)) << 1 |
                               (same(b.w, uneven) | same(b.n, uneven) | same(b.d, uneven)) << 2;
    return coder_.code(models_.odd(sort, steps, around), level == uneven) ? uneven : even;
  }

  bool code_known(const Before& b, bool bit) {
    const auto& c = kLevelClasses;
    const auto known = [](std::uint8_t level) { return std::size_t{kLevelClasses.three[level] == 2}; };
    const std::size_t faces = (c.three[b.w] * std::size_t{3} + c.three[b.n]) * 3 + c.three[b.d];
    const std::size_t edges = known(b.ne) | known(b.de) << 1 | known(b.ds) << 2 | known(b.nw) << 3 | known(b.dw) << 4;
    const std::size_t strength = ((c.five[b.w] * std::size_t{5} + c.five[b.n]) * 5 + c.five[b.d]) * 16 +
                                 c.four[b.de] * std::size_t{4} + c.four[b.ds];
    if (faces == 26 && edges == 31) return coder_.code(models_.known_inside(strength), bit);
    const std::size_t corners = known(b.dnw) | known(b.dne) << 1 | known(b.dsw) << 2 | known(b.dse) << 3;
    return coder_.code(models_.known(faces * 32 + edges, strength, corners * 27 + faces,
                                     known(b.w) | known(b.n) << 1 | known(b.d) << 2),
                       bit);
  }

  /// Whether it is occupied rather than free.
  bool code_sort(const Before& b, bool bit) {
    const auto& sort = kLevelClasses.sort;
    const auto& surface = kLevelClasses.surface;
    std::array<std::size_t, 3> around{};
    for (const std::uint8_t level : {b.ne, b.de, b.ds, b.dn, b.dw, b.nw}) ++around[sort[level]];
    const std::size_t faces = (sort[b.w] * std::size_t{3} + sort[b.n]) * 3 + sort[b.d];
    const std::size_t strength = (surface[b.w] * std::size_t{5} + surface[b.n]) * 5 + surface[b.d];
    if (faces == 13 && around[2] == 0) return coder_.code(models_.sort_inside(strength), bit);
    std::size_t corners = 0;
    for (const std::uint8_t level : {b.dsw, b.dse, b.ds, b.de, b.ne, b.d}) corners = corners * 3 + sort[level];
    return coder_.code(
        models_.sort(faces * 16 + std::min<std::size_t>(around[2], 3) * 4 + std::min<std::size_t>(around[1], 3),
                     strength, corners, sort[b.w]),
        bit);
  }

  /// Steps from saturation: 0..7. Neighbours of the other sort tell nothing and count as 8.
  std::size_t code_steps(const Before& b, std::size_t sort, std::size_t steps) {
    const auto of = [&](std::uint8_t level) -> std::size_t {
      return kLevelClasses.sort[level] == sort + 1 ? kLevelClasses.steps[level] : 8;
    };
    const std::size_t w = of(b.w);
    const std::size_t n = of(b.n);
    const std::size_t d = of(b.d);
    std::size_t sum = 0;
    std::size_t count = 0;
    for (const std::uint8_t level : {b.nw, b.ne, b.dw, b.de, b.dn, b.ds}) {
      const std::size_t s = of(level);
      sum += s == 8 ? 0 : s;
      count += s == 8 ? 0 : 1;
    }
    const std::size_t mean = count == 0 ? 15 : (2 * sum + count / 2) / count;  // in halves: 0..14
    const std::size_t equal = n == d ? (w == n ? 0 : 1) : w == n ? 2 : w == d ? 3 : 4;
    const std::size_t pattern =
        ((w < 8 ? w : n) * 5 + equal) * 8 + (same(b.ne, b.n) | same(b.de, b.d) << 1 | same(b.ds, b.d) << 2);
    std::size_t node = 1;
    for (int bit = 2; bit >= 0; --bit) {
      const bool set =
          coder_.code(models_.steps(sort, node, kTripleRanks.rank[w * 81 + n * 9 + d], d * 16 + mean, pattern),
                      (steps >> bit & 1U) != 0);
      node = node * 2 + (set ? 1 : 0);
    }
    return node & 7U;
  }

  Coder& coder_;
  BlockModels& models_;
};

}  // namespace g3d::net
