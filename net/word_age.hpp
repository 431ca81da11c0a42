// SPDX-License-Identifier: Apache-2.0
// How long a word was on its way, though nobody's clocks agree: by how much later it came than the quickest one did, as
// the sender's clock counts. What the quickest one took is not known; it is a few milliseconds.
#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/messages.hpp"

namespace g3d::net {

class WordAge {
 public:
  /// A word comes that was said at `said_ms` of the sender's clock. Returns when that was by our own clock, or later.
  hal::TimeNs note(std::uint32_t said_ms, hal::TimeNs now_ns) {
    if (!has_one_) {
      has_one_ = true;
      said_ms_ = said_ms;
      quickest_ns_ = now_ns;
      heard_ns_ = now_ns;
      return now_ns;
    }
    // By the sender's clock since the last word, which may wrap around.
    const hal::TimeNs later_ns = hal::TimeNs{static_cast<std::int32_t>(said_ms - said_ms_)} * 1'000'000;
    said_ms_ = said_ms;
    // Clocks run apart: what was quick once must not count for ever.
    quickest_ns_ += later_ns + std::max<hal::TimeNs>(0, now_ns - heard_ns_) / kDrift;
    heard_ns_ = now_ns;
    quickest_ns_ = std::min(quickest_ns_, now_ns);
    return quickest_ns_;
  }

 private:
  /// No two clocks run apart by more than 1 / kDrift.
  static constexpr hal::TimeNs kDrift = 5000;
  bool has_one_ = false;
  std::uint32_t said_ms_ = 0;
  hal::TimeNs quickest_ns_ = 0;  ///< when the last word was said by our own clock
  hal::TimeNs heard_ns_ = 0;
};

}  // namespace g3d::net
