// SPDX-License-Identifier: Apache-2.0
#include "net/version_ranges.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <utility>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using net::Version;
using net::VersionRange;
using net::VersionRanges;

namespace {

constexpr Version kRangesEnd = 200;

/// The same, version by version.
class PlainVersionSet {
 public:
  void add(const VersionRange& range) {
    for (Version v = range.after + 1; v <= range.upto; ++v) had_.insert(v);
  }
  [[nodiscard]] bool has(Version v) const { return had_.contains(v); }
  [[nodiscard]] bool covers(const VersionRange& range) const {
    for (Version v = range.after + 1; v <= range.upto; ++v) {
      if (!has(v)) return false;
    }
    return true;
  }
  /// Of what is missing in a range: the first version, and how many follow it without a break.
  [[nodiscard]] VersionRange first_gap(const VersionRange& range) const {
    Version first = range.after + 1;
    while (first <= range.upto && has(first)) ++first;
    Version end = first;
    while (end <= range.upto && !has(end)) ++end;
    return {first - 1, end - 1};
  }
  [[nodiscard]] Version upto() const { return first_gap({0, kRangesEnd + 1}).after; }
  [[nodiscard]] Version highest() const { return had_.empty() ? 0 : *had_.rbegin(); }
  /// Runs of versions above upto().
  [[nodiscard]] std::vector<VersionRange> beyond() const {
    std::vector<VersionRange> runs;
    for (const Version v : had_) {
      if (v <= upto()) continue;
      if (runs.empty() || runs.back().upto + 1 != v) runs.push_back({v - 1, v - 1});
      runs.back().upto = v;
    }
    return runs;
  }
  /// A run that begins, ends or lies next to this range, or upto() does: it needs no room of its own.
  [[nodiscard]] bool touches(const VersionRange& range) const {
    if (range.after <= upto()) return true;
    for (Version v = range.after; v <= range.upto + 1; ++v) {
      if (has(v)) return true;
    }
    return false;
  }

 private:
  std::set<Version> had_;
};

VersionRange random_version_range(tests::Random& random, std::uint32_t most_versions) {
  const Version after = random.below(kRangesEnd);
  return {after, std::min(kRangesEnd, after + random.below(most_versions + 1))};
}

void check_ranges_say_the_same(const VersionRanges& ranges, const PlainVersionSet& plain) {
  REQUIRE(ranges.upto() == plain.upto());
  REQUIRE(ranges.highest() == plain.highest());
  const std::vector<VersionRange> runs = plain.beyond();
  REQUIRE(std::equal(ranges.beyond().begin(), ranges.beyond().end(), runs.begin(), runs.end()));
}

/// `count` ranges of one version each, none touching another: all the room there is, if there are kMostBeyond.
VersionRanges ranges_with_holes(std::size_t count) {
  VersionRanges ranges(10);
  for (std::size_t i = 0; i < count; ++i) REQUIRE(ranges.add({20 + 10 * i, 21 + 10 * i}));
  return ranges;
}

}  // namespace

TEST_CASE("ranges of versions do what a set of single versions does, as long as there is room", "[net]") {
  int refusals = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    tests::Random random(seed);
    VersionRanges ranges;
    PlainVersionSet plain;
    const std::uint32_t most_versions = 1 + random.below(12);
    for (int step = 0; step < 60; ++step) {
      INFO("seed " << seed << " step " << step);
      const VersionRange range = random_version_range(random, most_versions);
      const bool finds_room =
          range.upto == range.after || plain.touches(range) || plain.beyond().size() < VersionRanges::kMostBeyond;
      REQUIRE(ranges.has_room_for(range) == finds_room);
      const VersionRanges before = ranges;
      REQUIRE(ranges.add(range) == finds_room);
      if (finds_room) {
        plain.add(range);
      } else {
        REQUIRE(ranges == before);
        ++refusals;
      }
      check_ranges_say_the_same(ranges, plain);
      const VersionRange asked = random_version_range(random, 40);
      REQUIRE(ranges.covers(asked) == plain.covers(asked));
      const VersionRange gap = ranges.first_gap(asked);
      const VersionRange plain_gap = plain.first_gap(asked);
      // Where nothing is missing, any empty range will do.
      REQUIRE((gap.upto > gap.after) == (plain_gap.upto > plain_gap.after));
      if (gap.upto > gap.after) REQUIRE(gap == plain_gap);
    }
  }
  CHECK(refusals > 100);  // room did run out
}

TEST_CASE("when all ranges are taken, what touches one or begins at the bottom still finds room", "[net]") {
  const VersionRanges full = ranges_with_holes(VersionRanges::kMostBeyond);
  REQUIRE(full.beyond().size() == VersionRanges::kMostBeyond);
  const Version last = full.highest();
  for (const VersionRange refused : {VersionRange{12, 15}, VersionRange{22, 24}, VersionRange{last + 1, last + 5}}) {
    VersionRanges ranges = full;
    CHECK_FALSE(ranges.has_room_for(refused));
    CHECK_FALSE(ranges.add(refused));
    CHECK(ranges == full);
  }
  for (const VersionRange taken :
       {VersionRange{10, 11}, VersionRange{3, 15}, VersionRange{0, 500}, VersionRange{15, 20}, VersionRange{21, 22},
        VersionRange{22, 30}, VersionRange{25, 75}, VersionRange{last, last + 9}, VersionRange{30, 31},
        VersionRange{40, 40}}) {
    INFO("(" << taken.after << ", " << taken.upto << "]");
    VersionRanges ranges = full;
    CHECK(ranges.has_room_for(taken));
    CHECK(ranges.add(taken));
    CHECK(ranges.covers(taken));
    CHECK(ranges.beyond().size() <= VersionRanges::kMostBeyond);
  }
}

TEST_CASE("gaps that are filled from below leave one number behind", "[net]") {
  VersionRanges ranges = ranges_with_holes(VersionRanges::kMostBeyond);
  const Version end = ranges.highest();
  int filled = 0;
  for (VersionRange gap = ranges.first_gap({0, end}); gap.upto > gap.after; gap = ranges.first_gap({0, end})) {
    REQUIRE(ranges.add(gap));
    REQUIRE(ranges.upto() >= gap.upto);
    ++filled;
  }
  CHECK(filled == static_cast<int>(VersionRanges::kMostBeyond));
  CHECK(ranges == VersionRanges(end));
  CHECK(ranges.beyond().empty());
}

TEST_CASE("empty and upside-down ranges change nothing and are always covered", "[net]") {
  VersionRanges ranges = ranges_with_holes(VersionRanges::kMostBeyond);
  const VersionRanges before = ranges;
  for (const VersionRange range :
       {VersionRange{}, VersionRange{15, 15}, VersionRange{1000, 1000}, VersionRange{40, 12}}) {
    CHECK(ranges.add(range));
    CHECK(ranges.covers(range));
    CHECK(ranges == before);
    const VersionRange gap = ranges.first_gap(range);
    CHECK(gap.upto <= gap.after);
  }
}

TEST_CASE("of other ranges all that there is room for is taken in", "[net]") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    INFO("seed " << seed);
    tests::Random random(seed);
    VersionRanges ranges, other;
    PlainVersionSet plain, plain_other;
    for (int i = 0; i < 14; ++i) {
      const VersionRange mine = random_version_range(random, 6), theirs = random_version_range(random, 6);
      if (ranges.add(mine)) plain.add(mine);
      if (other.add(theirs)) plain_other.add(theirs);
    }
    VersionRanges both = ranges;
    both.add(other);
    PlainVersionSet plain_both = plain;
    plain_both.add({0, plain_other.upto()});
    for (const VersionRange& run : plain_other.beyond()) {
      if (plain_both.touches(run) || plain_both.beyond().size() < VersionRanges::kMostBeyond) plain_both.add(run);
    }
    check_ranges_say_the_same(both, plain_both);
  }
}

TEST_CASE("ranges are equal if and only if they hold the same versions, whatever they went through", "[net]") {
  VersionRanges a(5), b;
  CHECK_FALSE(a == b);
  REQUIRE(b.add({3, 5}));
  CHECK_FALSE(a == b);  // as high, but not whole
  REQUIRE(b.add({0, 3}));
  CHECK(a == b);
  REQUIRE(a.add({8, 9}));
  CHECK_FALSE(a == b);
  CHECK_FALSE(b == a);
  REQUIRE(b.add({8, 10}));
  CHECK_FALSE(a == b);
  REQUIRE(a.add({9, 10}));
  CHECK(a == b);
  // What lies behind the ranges in memory does not count.
  VersionRanges c = ranges_with_holes(4);
  REQUIRE(c.add({0, 100}));
  CHECK(c == VersionRanges(100));
}
