// SPDX-License-Identifier: Apache-2.0
// Which symbols of a rateless sketch an item is in (after Yang, Gilad and Alizadeh 2024, "Practical Rateless Set
// Reconciliation", alpha = 0.5): all are in symbol 0, and in symbol i with a chance that falls as 2 / i, drawn from the
// item's id alone.
//
// After index i, the next is beyond n with a chance of ((i + 2) / (n + 2))^2, which one square root inverts. The paper
// has 1.5 for 2; sparser first symbols save up to 2 % of the symbols of few differences (measured). As the chance is of
// the form S(n) / S(i), the symbols are independent of each other, so a walk may start anew anywhere: they come in
// stretches (1..63, 64..511, each later one eight times as long), each drawn for itself, and whoever wants symbols far
// up does not walk through all those below.
//
// Two robots must walk the same way to the last index. Every number here is an integer, exact as a double as it is at
// most 2^53, or comes from one +, *, / or sqrt on binary64, which IEEE 754 wants rounded correctly on every machine;
// none is kept in wider registers (asserted below) or is subnormal, and there is no product with a sum after it that a
// compiler could fuse, -ffp-contract=off or not.
// Thread: any. Allocates nothing.
#pragma once

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <limits>

namespace g3d::net {

static_assert(std::numeric_limits<double>::is_iec559 && FLT_EVAL_METHOD == 0, "robots would disagree about symbols");

/// What stands for an item in one exchange: a keyed hash of it, so well mixed.
using SketchId = std::uint64_t;

/// Indices end here: products with what a gap may be stay far below 2^63.
inline constexpr std::uint32_t kMostSketchSymbols = std::uint32_t{1} << 24;

/// The finaliser of SplitMix64: every bit of `x` reaches every bit of the result.
[[nodiscard]] constexpr std::uint64_t sketch_mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

/// The chance that an item is in symbol `index` is numerator / denominator: 1 - ((i + 1) / (i + 2))^2 from index 1 on.
struct SymbolDensity {
  std::uint64_t numerator, denominator;
};
[[nodiscard]] constexpr SymbolDensity symbol_density(std::uint32_t index) {
  const std::uint64_t i = index;
  return i == 0 ? SymbolDensity{1, 1} : SymbolDensity{2 * i + 3, (i + 2) * (i + 2)};
}

/// The part of the walk within one stretch.
class StretchWalk {
 public:
  StretchWalk(SketchId id, std::uint32_t begin)
      : state_(sketch_mix(id + begin * 0x9E3779B97F4A7C15ULL)), at_(std::int64_t{begin} - 1) {}
  /// The next index; past the end of the stretch, one that means nothing.
  std::int64_t next() {
    state_ = state_ * 0xDA942042E4DD58B5ULL + 0x9E3779B97F4A7C15ULL;
    const double chance = static_cast<double>(static_cast<std::int64_t>(state_ >> 11) + 1);  // 1 .. 2^53, of 2^53
    const double leap = std::sqrt(0x1.0p53 / chance);                                        // 1 .. 2^26.5
    at_ = static_cast<std::int64_t>(static_cast<double>(at_ + 2) * leap) - 1;                // below 2^51
    return at_;
  }

 private:
  std::uint64_t state_;
  std::int64_t at_;
};

/// visit(index) for each symbol of [first, end) that the item is in, in ascending order; end <= kMostSketchSymbols.
template <typename Visit>
void for_each_symbol_of(SketchId id, std::uint32_t first, std::uint32_t end, Visit&& visit) {
  constexpr std::uint32_t kFirstStretchEnd = 64, kGrowth = 8;
  if (first == 0 && end > 0) visit(std::uint32_t{0});
  std::uint32_t begin = 1;
  for (std::uint32_t stretch_end = kFirstStretchEnd; begin < end; begin = stretch_end, stretch_end *= kGrowth) {
    if (stretch_end <= first) continue;
    const std::uint32_t stop = std::min(stretch_end, end);
    StretchWalk walk(id, begin);
    for (std::int64_t i = walk.next(); i < stop; i = walk.next()) {
      if (i >= first) visit(static_cast<std::uint32_t>(i));
    }
  }
}

}  // namespace g3d::net
