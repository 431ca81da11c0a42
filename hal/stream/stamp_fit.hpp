// SPDX-License-Identifier: Apache-2.0
// When something happened, on our own clock, that was stamped by another one of unknown epoch and sent to us. The two
// clocks differ by what the quickest of the recent messages says: others only waited longer on their way. So a message
// that was held up for a second is not taken for a new one. What every message needs at least stays in the stamps.
#pragma once

#include <limits>

#include "hal/messages.hpp"

namespace g3d::hal {

class StampFit {
 public:
  /// Between one and two of these the quickest message is remembered: 20 s at 100 ppm are 2 ms.
  static constexpr TimeNs kWindow_ns = 10'000'000'000;

  /// One message that was stamped `theirs_ns` and was here at `ours_ns`. Its time on our clock: never later than
  /// `ours_ns`, and later than that of the message before if its own stamp is.
  [[nodiscard]] TimeNs to_ours(TimeNs theirs_ns, TimeNs ours_ns);
  /// How much longer than the quickest the last one took.
  [[nodiscard]] TimeNs waited_ns() const { return waited_ns_; }
  /// Another clock may be there now.
  void forget();

 private:
  static constexpr TimeNs kNone = std::numeric_limits<TimeNs>::max();
  TimeNs window_begin_ns_ = 0;
  TimeNs least_ns_ = kNone;         ///< of ours - theirs, in this window
  TimeNs least_before_ns_ = kNone;  ///< in the one before
  TimeNs last_theirs_ns_ = 0;
  TimeNs last_ours_ns_ = 0;
  bool has_last_ = false;
  TimeNs waited_ns_ = 0;
};

}  // namespace g3d::hal
