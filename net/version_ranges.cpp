// SPDX-License-Identifier: Apache-2.0
#include "net/version_ranges.hpp"

#include <algorithm>

namespace g3d::net {

bool VersionRanges::add(const VersionRange& range) {
  if (range.upto <= range.after || range.upto <= upto_) return true;
  if (range.after <= upto_) {
    upto_ = range.upto;
    take_in_what_touches();
    return true;
  }
  VersionRange joined = range;
  std::size_t kept = 0;
  std::array<VersionRange, kMostBeyond + 1> all{};
  for (const VersionRange& old : beyond()) {
    if (old.upto < joined.after || old.after > joined.upto) {
      all[kept++] = old;
    } else {
      joined = {std::min(old.after, joined.after), std::max(old.upto, joined.upto)};
    }
  }
  if (kept == kMostBeyond) return false;
  std::size_t place = kept;
  for (; place > 0 && all[place - 1].after > joined.after; --place) all[place] = all[place - 1];
  all[place] = joined;
  count_ = kept + 1;
  std::copy_n(all.begin(), count_, beyond_.begin());
  return true;
}

void VersionRanges::take_in_what_touches() {
  std::size_t taken = 0;
  for (; taken < count_ && beyond_[taken].after <= upto_; ++taken) upto_ = std::max(upto_, beyond_[taken].upto);
  std::copy(beyond_.begin() + static_cast<std::ptrdiff_t>(taken), beyond_.begin() + static_cast<std::ptrdiff_t>(count_),
            beyond_.begin());
  count_ -= taken;
}

void VersionRanges::add(const VersionRanges& other) {
  (void)add(VersionRange{0, other.upto_});
  for (const VersionRange& range : other.beyond()) (void)add(range);
}

bool VersionRanges::covers(const VersionRange& range) const {
  if (range.upto <= range.after || range.upto <= upto_) return true;
  return std::any_of(beyond_.begin(), beyond_.begin() + static_cast<std::ptrdiff_t>(count_),
                     [&](const VersionRange& had) { return had.after <= range.after && had.upto >= range.upto; });
}

VersionRange VersionRanges::first_gap(const VersionRange& range) const {
  Version after = std::max(range.after, upto_);
  for (const VersionRange& had : beyond()) {
    if (had.after > after) return {std::min(after, range.upto), std::min(had.after, range.upto)};
    after = std::max(after, had.upto);
  }
  return {std::min(after, range.upto), range.upto};
}

bool VersionRanges::operator==(const VersionRanges& other) const {
  return upto_ == other.upto_ &&
         std::equal(beyond().begin(), beyond().end(), other.beyond().begin(), other.beyond().end());
}

}  // namespace g3d::net
