// SPDX-License-Identifier: Apache-2.0
#include "mapper/stage_times.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace g3d::mapper {

// Below 2^5 ns every nanosecond has its own bucket; above, the five bits after the leading one choose.
std::size_t StageTimes::bucket_of(std::uint64_t ns) {
  if (ns < (1U << kSubBits)) return static_cast<std::size_t>(ns);
  const int shift = std::bit_width(ns) - 1 - kSubBits;
  const auto sub = static_cast<std::size_t>(ns >> shift) - (1U << kSubBits);
  return (static_cast<std::size_t>(shift + 1) << kSubBits) + sub;
}

std::uint64_t StageTimes::upper_bound_ns(std::size_t bucket) {
  if (bucket < (1U << kSubBits)) return bucket;
  const auto shift = (bucket >> kSubBits) - 1;
  const std::uint64_t leading = (bucket & ((1U << kSubBits) - 1)) + (1U << kSubBits);
  return ((leading + 1) << shift) - 1;
}

void StageTimes::add(std::int64_t duration_ns) {
  const auto ns = static_cast<std::uint64_t>(std::max<std::int64_t>(duration_ns, 0));
  ++buckets_[std::min(bucket_of(ns), kBuckets - 1)];
  ++count_;
  max_ns_ = std::max(max_ns_, ns);
  sum_ns_ += static_cast<double>(ns);
}

double StageTimes::percentile_us(double fraction) const {
  const auto wanted =
      static_cast<std::uint64_t>(std::ceil(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t bucket = 0; bucket < kBuckets && count_ > 0; ++bucket) {
    seen += buckets_[bucket];
    if (seen >= wanted && seen > 0) return static_cast<double>(std::min(upper_bound_ns(bucket), max_ns_)) / 1e3;
  }
  return 0.0;
}

double StageTimes::mean_us() const { return count_ == 0 ? 0.0 : sum_ns_ / static_cast<double>(count_) / 1e3; }

}  // namespace g3d::mapper
