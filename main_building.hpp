// SPDX-License-Identifier: Apache-2.0
// What `g3dmap building` tells of itself, the outside truth, for tests and people; and what a robot in it tells of its
// camera.
#pragma once

#include <algorithm>
#include <cstddef>

#include "hal/stream/frame_server.hpp"
#include "hal/stream/stream_camera.hpp"
#include "hal/twist.hpp"
#include "mapper/json_writer.hpp"

namespace g3d::hal {
class BaseCable;
class SimBuilding;
}  // namespace g3d::hal

namespace g3d {

/// Contacts that are listed of each robot; all are counted.
inline constexpr std::size_t kMostContactsTold = 32;

/// Writes the key "camera" and the object.
void write_served(mapper::JsonWriter& json, const hal::ServedCounts& counts);
/// The other side: what a robot's report says of its camera's stream, under the key "camera".
void write_stream(mapper::JsonWriter& json, const hal::StreamCounts& counts);
/// Writes members into an object that is open. Nothing moves meanwhile.
void write_truth_of(mapper::JsonWriter& json, hal::SimBuilding& building, const hal::BaseCable& cable,
                    std::size_t robot, const hal::PlanarPose& start);

}  // namespace g3d
