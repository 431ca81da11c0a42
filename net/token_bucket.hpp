// SPDX-License-Identifier: Apache-2.0
// So many per second and so many at once, in one number: the time at which the bucket is full again. Plain; the caller
// says what time it is.
#pragma once

#include <algorithm>
#include <limits>

#include "hal/messages.hpp"

namespace g3d::net {

/// Both above 0.
struct TokenRate {
  double per_s;
  double burst;
  [[nodiscard]] hal::TimeNs token_ns() const { return static_cast<hal::TimeNs>(1e9 / per_s); }
  [[nodiscard]] hal::TimeNs burst_ns() const { return static_cast<hal::TimeNs>(1e9 * burst / per_s); }
};

class TokenBucket {
 public:
  [[nodiscard]] bool holds_one(TokenRate rate, hal::TimeNs now_ns) const {
    return start(rate, now_ns) + rate.token_ns() - now_ns <= rate.burst_ns();
  }
  [[nodiscard]] bool take(TokenRate rate, hal::TimeNs now_ns) {
    if (!holds_one(rate, now_ns)) return false;
    full_at_ns_ = start(rate, now_ns) + rate.token_ns();
    return true;
  }
  /// Takes tokens that may not be there. The debt is at most one burst, so that silence ends.
  void charge(TokenRate rate, double tokens, hal::TimeNs now_ns) {
    const auto cost_ns = static_cast<hal::TimeNs>(tokens * 1e9 / rate.per_s);
    full_at_ns_ = std::min(start(rate, now_ns) + cost_ns, now_ns + 2 * rate.burst_ns());
  }
  /// From then on, a forgotten bucket and a remembered one are the same.
  [[nodiscard]] hal::TimeNs full_at_ns() const { return full_at_ns_; }

 private:
  /// A clock that was set back must not keep the bucket empty for the difference.
  [[nodiscard]] hal::TimeNs start(TokenRate rate, hal::TimeNs now_ns) const {
    return std::clamp(full_at_ns_, now_ns, now_ns + 2 * rate.burst_ns());
  }

  hal::TimeNs full_at_ns_ = std::numeric_limits<hal::TimeNs>::min();
};

}  // namespace g3d::net
