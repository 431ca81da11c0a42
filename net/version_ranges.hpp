// SPDX-License-Identifier: Apache-2.0
// What somebody has of one lane of a layer: everything that still stands of the versions up to `upto`, and of some
// ranges (after, upto] beyond, because datagrams get lost on the way. Versions that were superseded meanwhile count as
// had: nothing of them stands.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "net/layer_id.hpp"

namespace g3d::net {

struct VersionRange {
  Version after = 0;
  Version upto = 0;
  bool operator==(const VersionRange&) const = default;
};

class VersionRanges {
 public:
  static constexpr std::size_t kMostBeyond = 16;

  VersionRanges() = default;
  explicit VersionRanges(Version upto) : upto_(upto) {}

  /// False if there is no room for a range more; then nothing has changed. What begins at upto() or below, or touches
  /// a range that is there, always finds room, so gaps can always be filled from below. Empty ranges change nothing.
  bool add(const VersionRange& range);
  [[nodiscard]] bool has_room_for(const VersionRange& range) const { return VersionRanges(*this).add(range); }
  /// As much of it as there is room for.
  void add(const VersionRanges& other);

  [[nodiscard]] Version upto() const { return upto_; }
  /// Ascending, neither empty nor touching each other nor upto().
  [[nodiscard]] std::span<const VersionRange> beyond() const { return {beyond_.data(), count_}; }
  /// The highest version in it.
  [[nodiscard]] Version highest() const { return count_ == 0 ? upto_ : beyond_[count_ - 1].upto; }
  [[nodiscard]] bool covers(const VersionRange& range) const;
  /// The first part of `range` that is missing; an empty one if nothing is.
  [[nodiscard]] VersionRange first_gap(const VersionRange& range) const;
  bool operator==(const VersionRanges& other) const;

 private:
  void take_in_what_touches();

  Version upto_ = 0;
  std::array<VersionRange, kMostBeyond> beyond_{};
  std::size_t count_ = 0;
};

}  // namespace g3d::net
