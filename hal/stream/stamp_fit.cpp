// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/stamp_fit.hpp"

#include <algorithm>

namespace g3d::hal {

TimeNs StampFit::to_ours(TimeNs theirs_ns, TimeNs ours_ns) {
  if (least_ns_ == kNone) {
    window_begin_ns_ = ours_ns;
  } else if (ours_ns - window_begin_ns_ >= kWindow_ns) {
    least_before_ns_ = least_ns_;
    least_ns_ = kNone;
    window_begin_ns_ = ours_ns;
  }
  least_ns_ = std::min(least_ns_, ours_ns - theirs_ns);
  TimeNs at_ns = std::min(theirs_ns + std::min(least_ns_, least_before_ns_), ours_ns);
  waited_ns_ = ours_ns - at_ns;
  // A quicker message than all before moves the fit: time must not go back by that.
  if (has_last_ && theirs_ns > last_theirs_ns_) at_ns = std::min(std::max(at_ns, last_ours_ns_ + 1), ours_ns);
  last_theirs_ns_ = theirs_ns;
  last_ours_ns_ = at_ns;
  has_last_ = true;
  return at_ns;
}

void StampFit::forget() { *this = StampFit{}; }

}  // namespace g3d::hal
