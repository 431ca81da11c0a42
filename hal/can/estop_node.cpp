// SPDX-License-Identifier: Apache-2.0
#include "hal/can/estop_node.hpp"

namespace g3d::hal::can {

void EstopNode::on_message(const Message& message, TimeNs received_ns) {
  if (const auto* heartbeat = std::get_if<Heartbeat>(&message); heartbeat && heartbeat->node == options_.node) {
    // It came too late, though nobody may have looked in between.
    if (was_well_ && !is_alive(received_ns)) stop_is_due_ = true;
    was_heard_ = true;
    last_heartbeat_ns_ = received_ns;
    state_ = heartbeat->state;
    ++heartbeats_;
    if (state_ != NmtState::operational && was_well_) stop_is_due_ = true;
    // It starts without errors, and tells again of those that it has.
    if (state_ == NmtState::boot_up) has_emergency_ = false;
  }
  if (const auto* emergency = std::get_if<Emergency>(&message); emergency && emergency->node == options_.node) {
    last_emergency_ = *emergency;
    ++emergencies_;
    has_emergency_ = !emergency->is_all_clear();
    stop_is_due_ |= has_emergency_;
  }
}

bool EstopNode::is_alive(TimeNs now_ns) const {
  return was_heard_ && now_ns - last_heartbeat_ns_ <= options_.heartbeat_ns;
}

StopWord EstopNode::word(TimeNs now_ns) {
  const bool alive = is_alive(now_ns);
  losses_ += was_alive_ && !alive;
  was_alive_ = alive;
  const bool well = alive && state_ == NmtState::operational && !has_emergency_;
  const bool stop = stop_is_due_ || has_emergency_ || (was_well_ && !well);
  stop_is_due_ = false;
  was_well_ |= well;
  if (stop) return StopWord::stop;
  return well ? StopWord::go : StopWord::not_yet;
}

}  // namespace g3d::hal::can
