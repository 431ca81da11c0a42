// SPDX-License-Identifier: Apache-2.0
// How old feedback is when it arrives. The base stamps its packets with a clock of its own, so a delay that was always
// there cannot be seen, but one that grows can: against the packet that came fastest.
#pragma once

#include "hal/kobuki/feedback.hpp"

namespace g3d::hal::kobuki {

/// One thread. Allocates nothing.
class LinkDelay {
 public:
  /// Returns by how much later than the fastest ones this packet came, >= 0.
  TimeNs update(const Feedback& feedback);

 private:
  bool started_ = false;
  std::uint16_t last_stamp_ms_ = 0;
  TimeNs last_received_ns_ = 0;
  TimeNs base_time_ns_ = 0;  // of the base, unwrapped, since the first packet
  TimeNs fastest_ns_ = 0;    // smallest received - base_time
};

}  // namespace g3d::hal::kobuki
