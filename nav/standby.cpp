// SPDX-License-Identifier: Apache-2.0
#include "nav/standby.hpp"

namespace g3d::nav {

Standby::Standby(double retry_s, int max_retries)
    : retry_wait_ns_(static_cast<TimeNs>(retry_s * 1e9)), max_retries_(max_retries) {}

Standby::Step Standby::step(bool must_stand, TimeNs now) {
  Step step;
  step.began = must_stand && !is_standing_;
  step.ended = !must_stand && is_standing_;
  if (must_stand) step.stood_ns = now - last_step_ns_;
  is_standing_ = must_stand;
  last_step_ns_ = now;
  return step;
}

bool Standby::should_retry(MissionState state, TimeNs now) {
  if (state != MissionState::needs_help || now < retry_ns_ || retries_ >= max_retries_) return false;
  ++retries_;
  return true;
}

}  // namespace g3d::nav
