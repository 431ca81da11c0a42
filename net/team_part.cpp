// SPDX-License-Identifier: Apache-2.0
#include "net/team_part.hpp"

#include <algorithm>
#include <cmath>

#include "net/team_frame.hpp"

namespace g3d::net {

void TeamPart::on_round(MapSharing& sharing, hal::TimeNs now_ns) {
  (void)link_.word.read_newer(seen_words_, word_);
  if (seen_words_ == 0) return;
  if (talk_ == nullptr) {
    talk_ = std::make_unique<TeamTalk>(TeamTalkOptions{}, sharing.gossip(), sharing.store(), now_ns);
  }
  const hal::Pose& T_world_map = sharing.T_world_map();
  if (!talk_->on_time(in_world(word_, T_world_map), state(sharing), now_ns)) return;
  link_.sight.write(in_map(talk_->sight(), T_world_map));
}

StateWord TeamPart::state(const MapSharing& sharing) const {
  StateWord word;
  word.radius_m = radius_m_;
  word.map_incarnation = sharing.gossip().options().self.incarnation;
  nav::LiveStatus status;
  if (status_.read(status) == 0) return word;
  word.mission = status.state;
  word.battery_percent = static_cast<std::uint8_t>(std::lround(100.0 * std::clamp(status.battery_charge, 0.0, 1.0)));
  return word;
}

}  // namespace g3d::net
