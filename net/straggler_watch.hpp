// SPDX-License-Identifier: Apache-2.0
// While a rotation of the fleet's key goes on, robots that have only the old key could not hear those that have both.
// So whoever has both speaks under the old key as long as it hears, fresh, somebody who has only that. What it says so
// is marked (DatagramKind::holds_newer), so that two who have both do not keep each other at the old key. One thread.
#pragma once

#include <limits>

#include "hal/messages.hpp"
#include "net/datagram_seal.hpp"

namespace g3d::net {

class StragglerWatch {
 public:
  /// One who is not heard for so long keeps nobody at the old key.
  static constexpr hal::TimeNs kPatience_ns = 10'000 * hal::kMillisecond_ns;

  /// Of a datagram that is authentic and fresh: a recording says nothing about who is still there.
  void note(const Envelope& envelope, hal::TimeNs now_ns) {
    if (envelope.previous_epoch && !envelope.kind.holds_newer) until_ns_ = now_ns + kPatience_ns;
  }
  void forget() { until_ns_ = std::numeric_limits<hal::TimeNs>::min(); }
  [[nodiscard]] bool hears_one(hal::TimeNs now_ns) const { return now_ns < until_ns_; }

 private:
  hal::TimeNs until_ns_ = std::numeric_limits<hal::TimeNs>::min();
};

}  // namespace g3d::net
