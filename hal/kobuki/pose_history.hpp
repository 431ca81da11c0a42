// SPDX-License-Identifier: Apache-2.0
// Where the base was over the last second, so that an image can be given the pose of the moment in which it was taken.
// A plain value: it crosses threads through hal::Latest.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/messages.hpp"
#include "hal/twist.hpp"

namespace g3d::hal::kobuki {

class PoseHistory {
 public:
  static constexpr std::size_t kPoses = 64;                   ///< 1.28 s
  static constexpr TimeNs kMaxGap_ns = 200'000'000;           ///< between two poses that are interpolated
  static constexpr TimeNs kMaxExtrapolation_ns = 40'000'000;  ///< beyond the newest: two packets

  static constexpr TimeNs kMinStep_ns = 10'000'000;  ///< between the two that it goes on from beyond the newest

  /// Stamps that are not later than the one before are ignored.
  void add(TimeNs stamp_ns, const PlanarPose& T_world_base);
  /// Way and heading linear between the two nearest, beyond the newest as between it and the
  /// one at least kMinStep_ns before. Nothing if `stamp_ns`
  /// is before the oldest, too far beyond the newest, or in a gap.
  [[nodiscard]] std::optional<PlanarPose> at(TimeNs stamp_ns) const;
  [[nodiscard]] std::size_t size() const { return count_ < kPoses ? static_cast<std::size_t>(count_) : kPoses; }

 private:
  struct Entry {
    TimeNs stamp_ns = 0;
    PlanarPose T_world_base;
  };
  /// 0 is the newest.
  [[nodiscard]] const Entry& back(std::size_t i) const { return entries_[(count_ - 1 - i) % kPoses]; }

  std::array<Entry, kPoses> entries_{};
  std::uint64_t count_ = 0;
};

}  // namespace g3d::hal::kobuki
