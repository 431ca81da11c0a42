// SPDX-License-Identifier: Apache-2.0
// What board and command line say of the fleet that a program belongs to, and the program's part in it: socket, gate
// and sharing thread, begun and ended in the right order.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "board/board.hpp"
#include "hal/clock.hpp"
#include "hal/result.hpp"
#include "main_commands.hpp"
#include "mapper/json_writer.hpp"
#include "mapper/submaps/driving_loops.hpp"
#include "mapper/voxel_map.hpp"
#include "net/fleet_key.hpp"
#include "net/mqtt_port.hpp"
#include "net/port_mux.hpp"
#include "net/sharing_thread.hpp"
#include "net/team_part.hpp"
#include "net/udp_port.hpp"

namespace g3d {

/// Puts what the command line says of the network into the board. Errors: bad_usage.
[[nodiscard]] hal::Result<void> set_network(const NetworkOptions& options, board::Board& board);
[[nodiscard]] inline bool has_fleet(const board::Board& board) { return board.network_key != "none"; }

/// All that is needed to take part; nothing is open yet.
struct FleetPlan {
  net::FleetKey keys;
  net::UdpPortOptions port;
  double radio_bandwidth_Bps = 0.0;
  std::optional<net::MqttPortOptions> broker;
  double broker_bandwidth_Bps = 0.0;
  net::SharingThreadOptions sharing;
  std::string keep;  ///< folder for what is to survive a restart; empty: nothing is
};
/// Reads the key, and the login for a broker. `has_loops`: what is shared are submaps. Errors: bad_usage, and those of
/// these files.
[[nodiscard]] hal::Result<FleetPlan> plan_fleet(const board::Board& board, bool has_map, bool has_loops = false);

class Fleet {
 public:
  /// `own` and `clock` outlive this. Errors: those of the socket, of MqttPort::open(), and of the folder where layers
  /// are kept.
  [[nodiscard]] static hal::Result<std::unique_ptr<Fleet>> open(FleetPlan plan, const mapper::VoxelMap& own,
                                                                hal::Clock& clock);

  /// A robot's threads speak with the others of its team by way of this. All outlive it. Before start().
  void speak_for(nav::TeamLink& link, const hal::Latest<nav::LiveStatus>& status);
  /// What this robot shares are its submaps: for a plan with `has_loops`. They outlive it. Before start().
  void share_submaps(const mapper::submaps::DrivingLoops& loops) { loops_ = &loops; }
  void start() { thread_->start(); }
  /// Goes on sharing until all that are in reach hold what we have, but no longer than so many seconds.
  void settle(double most_s, const std::function<bool()>& is_given_up);
  void stop();

  [[nodiscard]] net::SharingThread& thread() { return *thread_; }
  [[nodiscard]] const net::SharingThread& thread() const { return *thread_; }
  /// To "peers" and "peers text", from a control socket's thread; nothing to other words.
  [[nodiscard]] std::optional<std::string> answer(std::string_view request);

  // After stop()
  /// The map of all layers, our own included, in the fleet's world.
  [[nodiscard]] std::unique_ptr<net::MergedMap> whole_map() const;
  /// What a person should know of it; empty: nothing.
  [[nodiscard]] std::string warning() const;
  /// Writes "id", "merged_hash", and the objects "sharing" and "robots".
  void write(mapper::JsonWriter& json, const std::string& merged_hash, double run_s) const;

 private:
  Fleet(FleetPlan plan, std::unique_ptr<net::UdpPort> port, std::unique_ptr<net::MqttPort> broker,
        std::unique_ptr<net::KeptLayers> kept, const mapper::VoxelMap& own, hal::Clock& clock);

  hal::Clock& clock_;
  const mapper::VoxelMap& own_;
  std::unique_ptr<net::UdpPort> port_;
  std::unique_ptr<net::MqttPort> broker_;  ///< nullptr: none
  net::PortMux mux_;                       ///< of port_, then broker_
  std::unique_ptr<net::TeamPart> team_;    ///< nullptr: a base station, which drives nowhere
  const mapper::submaps::DrivingLoops* loops_ = nullptr;
  std::unique_ptr<net::SharingThread> thread_;
};

/// "2 robots, 3 layers, 1.2 MB": for a line of progress.
[[nodiscard]] std::string brief_text(const net::SharingBrief& brief);

}  // namespace g3d
