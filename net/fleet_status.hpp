// SPDX-License-Identifier: Apache-2.0
// Who knows what, for people: what this robot holds of every layer, which robots it hears, what each of them lacks of
// that, and which datagrams were refused. `g3dmap peers` prints it. Cold paths only: it allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/messages.hpp"
#include "net/datagram_gate.hpp"
#include "net/fleet_radio.hpp"
#include "net/map_sharing.hpp"

namespace g3d::net {

/// What we hold of a layer.
struct LayerStatus {
  LayerId id;
  Version upto = 0;     ///< everything up to here, in all its lanes
  Version highest = 0;  ///< the newest that is here, gaps before it or not
  std::uint32_t records = 0;
  std::optional<float> resolution_m = std::nullopt;  ///< edge of its voxels; none: it has not said where it stands yet
};

/// What another robot is known to have of it.
struct PeerLayerStatus {
  LayerId id;
  bool is_told = false;  ///< it has said something of this layer
  Version upto = 0;
  Version highest = 0;
  bool is_ahead = false;            ///< it has newer things than we
  std::uint32_t lacks_records = 0;  ///< of those that we hold
  std::uint64_t lacks_bytes = 0;
  bool is_at_least = false;  ///< it lacks more than was counted
};

struct PeerStatus {
  RobotId robot = 0;
  PeerState state = PeerState::gone;
  Address address = kEverybody;
  double heard_s = 0.0;         ///< ago
  bool holds_the_same = false;  ///< as we, by what it said last
  std::vector<PeerLayerStatus> layers;
};

struct FleetStatus {
  LayerId self;
  float resolution_m = 0.0F;  ///< of our own map; layers of another one are passed on, but not merged
  std::uint64_t digest = 0;
  std::uint64_t bytes = 0;  ///< of all records that are held, as they travel
  std::vector<LayerStatus> layers;
  std::vector<PeerStatus> peers;
  // The key
  std::uint16_t epoch = 0;
  bool hears_old_key = false;     ///< a rotation is not finished
  bool hears_stragglers = false;  ///< and somebody has spoken by the old key of late
  std::uint64_t rejected_keys = 0;
  GateCounts gate;
  RadioCounts radio;
  GossipCounts gossip;
};

/// How many records are looked at to say what others lack: a hundredth of a second's work.
inline constexpr std::uint32_t kMostCountedRecords = 50'000;

[[nodiscard]] FleetStatus fleet_status(const MapSharing& sharing, const DatagramGate& gate, const FleetRadio& radio,
                                       std::uint64_t rejected_keys, hal::TimeNs now_ns);
/// Layers that are not merged, as their voxels have another size.
[[nodiscard]] std::size_t layers_of_other_grids(const FleetStatus& status);
[[nodiscard]] const char* to_string(PeerState state);
/// At most kMostStatus_bytes: of a large fleet some robots' layers are left out, and it says how many.
inline constexpr std::size_t kMostStatus_bytes = 128 * 1024;
[[nodiscard]] std::string to_json(const FleetStatus& status);
[[nodiscard]] std::string to_text(const FleetStatus& status);

}  // namespace g3d::net
