// SPDX-License-Identifier: Apache-2.0
// How long one stage took, frame by frame: a histogram of fixed size, so that a day-long run needs no more memory than
// a second. Buckets are 1/32 of an octave wide: a percentile is at most 3.2 % above the true one; the maximum is exact.
// One thread writes; read it after that thread has ended.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace g3d::mapper {

class StageTimes {
 public:
  void add(std::int64_t duration_ns);

  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// Smallest bucket bound that at least `fraction` (0..1] of the durations do not exceed; 0 when there are none.
  [[nodiscard]] double percentile_us(double fraction) const;
  [[nodiscard]] double max_us() const { return static_cast<double>(max_ns_) / 1e3; }
  [[nodiscard]] double mean_us() const;

 private:
  static constexpr int kSubBits = 5;
  static constexpr std::size_t kBuckets = (64 - kSubBits) << kSubBits;
  static std::size_t bucket_of(std::uint64_t ns);
  static std::uint64_t upper_bound_ns(std::size_t bucket);

  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  std::uint64_t max_ns_ = 0;
  double sum_ns_ = 0.0;
};

}  // namespace g3d::mapper
