// SPDX-License-Identifier: Apache-2.0
// What a report says of a robot's part in sharing the map, and in its team.
#pragma once

#include "mapper/json_writer.hpp"
#include "net/map_sharing.hpp"
#include "net/team_talk.hpp"

namespace g3d::net {

/// The key "sharing" and its object; `run_s`: over which what was sent is spread.
void write_sharing(mapper::JsonWriter& json, const MapSharing& sharing, double run_s);
/// The key "in_team" and its object.
void write_in_team(mapper::JsonWriter& json, const TeamTalk& talk);

}  // namespace g3d::net
