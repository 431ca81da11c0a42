// SPDX-License-Identifier: Apache-2.0
// The thread by which a robot, or a base station, is part of a fleet: it alone owns the way to the network, the layers
// of all robots and the map merged from them.
//
//   mapper thread ──changed slots, a bit each──▶ ┐                                  ┌─▶ navigator thread (LiveView)
//   own map ──blocks, under their sequence locks─┤ sharing thread ◀──▶ gate ◀──▶ UDP ├─▶ brief state, latest value
//   file of the fleet's key ──once a second────▶ ┘                                  └─▶ full status, when asked
//
// It waits for datagrams at most some milliseconds, so gossip is on time. Nobody waits for it but people who ask. It is
// not on the way from camera to base: merging allocates.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "hal/clock.hpp"
#include "hal/latest.hpp"
#include "hal/parking.hpp"
#include "mapper/stage_times.hpp"
#include "mapper/voxel_map.hpp"
#include "net/datagram_gate.hpp"
#include "net/fleet_radio.hpp"
#include "net/fleet_status.hpp"
#include "net/key_file_watch.hpp"
#include "net/live_view.hpp"
#include "net/map_sharing.hpp"

namespace g3d::net {

struct SharingThreadOptions {
  SharingOptions sharing;
  bool has_map = true;   ///< false: a base station, which has nothing of its own to tell
  std::string key_path;  ///< looked at so often; empty: the keys stay
  hal::TimeNs key_period_ns = 1'000'000'000;
  std::size_t most_sessions = 64;
  hal::TimeNs wait_ns = 5'000'000;
};

/// What it works with. All outlive it.
struct SharingParts {
  DatagramPort& port;
  std::function<void(hal::TimeNs at_most_ns)> wait;  ///< until something has come; the sharing thread
  hal::Clock& clock;
  const mapper::VoxelMap& own;  ///< the robot's map; an empty one at a base station
  /// Called with the time after every round, by the sharing thread: for what else belongs to it. May be empty.
  std::function<void(MapSharing& sharing, hal::TimeNs now_ns)> on_round = {};
  /// Told by the sharing thread when the key's file was changed: an error, or nothing if it was taken. May be empty.
  std::function<void(const hal::Error* error, std::uint16_t epoch)> on_key = {};
};

struct SharingBrief {
  std::uint32_t alive = 0;  ///< other robots
  std::uint32_t suspect = 0;
  std::uint32_t gone = 0;
  std::uint32_t layers = 0;
  std::uint32_t records = 0;
  std::uint64_t payload_bytes = 0;
  std::uint64_t sent_bytes = 0;
  std::uint64_t refused_datagrams = 0;
  std::uint16_t epoch = 0;
  std::uint64_t digest = 0;  ///< of all records
  /// Our own map is published as it is, and all robots that are alive hold the same as we.
  bool is_told = false;
  hal::TimeNs stamp_ns = 0;
};

class SharingThread {
 public:
  /// `kept`: what an earlier start has left, and where it goes on to be kept; nullptr: nowhere.
  SharingThread(const SharingThreadOptions& options, FleetKey keys, const SharingParts& parts,
                std::unique_ptr<KeptLayers> kept = nullptr);
  ~SharingThread();
  SharingThread(const SharingThread&) = delete;
  SharingThread& operator=(const SharingThread&) = delete;

  /// Once.
  void start();
  /// Ends the thread, after what is kept has gone to the disk. Once stopped it is not started again.
  void stop();

  /// The mapper's thread: these blocks of the own map have changed.
  void note_changed(std::span<const std::uint32_t> slots) { sharing_.note_changed(slots); }
  /// The navigator's thread, as SharedSight says.
  [[nodiscard]] LiveView& view() { return view_; }
  /// Any thread, twice a second a new one.
  [[nodiscard]] const hal::Latest<SharingBrief>& brief() const { return brief_; }
  /// One thread: how it is at the moment. Nothing if the thread does not answer within two seconds.
  [[nodiscard]] std::optional<FleetStatus> ask();
  /// Blocks may be copied under their sequence locks while it runs.
  [[nodiscard]] const mapper::VoxelMap& others() const { return sharing_.others().map(); }

  // After stop()
  [[nodiscard]] const MapSharing& sharing() const { return sharing_; }
  [[nodiscard]] FleetStatus status() const;
  [[nodiscard]] double cpu_s() const { return static_cast<double>(cpu_ns_) * 1e-9; }
  [[nodiscard]] std::uint64_t view_refused_blocks() const { return view_.refused_blocks(); }
  /// How long a round took, without the wait.
  [[nodiscard]] const mapper::StageTimes& round_times() const { return round_times_; }

 private:
  enum class Asking : std::uint8_t { nobody, asked, answered };

  void loop();
  void round(hal::TimeNs now_ns);
  void look_at_key(hal::TimeNs now_ns);
  void answer(hal::TimeNs now_ns);
  void tell(hal::TimeNs now_ns);

  const SharingThreadOptions options_;
  const SharingParts parts_;
  DatagramGate gate_;
  FleetRadio radio_;
  MapSharing sharing_;
  LiveView view_;
  std::optional<KeyFileWatch> key_file_;
  bool has_told_pose_ = false;
  std::atomic<std::uint64_t> rejected_keys_{0};

  std::atomic<Asking> asking_{Asking::nobody};  // whose turn it is with status_
  FleetStatus status_;
  hal::Latest<SharingBrief> brief_;
  WriterCounts told_writer_;  // at the last tell()
  ChainCounts told_chain_;
  hal::TimeNs told_ns_ = 0;

  mapper::StageTimes round_times_;
  std::int64_t cpu_ns_ = 0;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace g3d::net
