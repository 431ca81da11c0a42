// SPDX-License-Identifier: Apache-2.0
// A whole robot without threads: the base's bytes and the camera's frames in, bytes for the base out, a map and a
// mission in between. Whoever owns the clock calls it: the simulation in lockstep, or the threads of a real board.
//
//   line ──bytes──▶ BaseDriver ──pose, safety──▶ Navigator ──velocity──▶ BaseDriver ──bytes──▶ line
//   frame ─▶ Senses ─▶ pose at its stamp ─▶ Placing ─▶ Mapper ──changed blocks──▲
//
// All calls from one thread; at equal times on_line comes before on_frame. Frames that were delivered are integrated or
// counted under one reason.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "hal/byte_line.hpp"
#include "hal/clock.hpp"
#include "hal/kobuki/base_driver.hpp"
#include "hal/messages.hpp"
#include "mapper/mapper.hpp"
#include "mapper/report.hpp"
#include "mapper/stage_times.hpp"
#include "mapper/submaps/driving_loops.hpp"
#include "nav/body_mask.hpp"
#include "nav/live_status.hpp"
#include "nav/navigator.hpp"
#include "nav/placing.hpp"
#include "nav/senses.hpp"
#include "nav/shared_sight.hpp"

namespace g3d::nav {

struct RobotConfig {
  mapper::MapperConfig mapper;
  NavigatorConfig navigator;
  hal::kobuki::BaseDriverOptions driver;
  hal::FrameWatchOptions frame_watch;
  hal::CameraModel camera;
  hal::Pose T_base_camera;
  hal::PlanarPose T_world_start;                                        ///< where odometry begins
  double robot_height_m = 0.6;                                          ///< its own cylinder is free at the start
  std::optional<mapper::align::AlignOptions> align = std::nullopt;      ///< none: odometry is believed
  std::optional<mapper::submaps::DrivingOptions> loops = std::nullopt;  ///< needs align; none: the map stays as it is
  int steps_per_command = 2;  ///< the navigator decides at every so many-th tick of 20 ms
};

class Robot {
 public:
  /// `clock` times the stages and nothing else.
  Robot(const RobotConfig& config, hal::Clock& clock);

  /// Every 20 ms: takes what the line gave, decides, and sends what is due.
  void on_line(hal::ByteLine& line, hal::TimeNs now);
  /// Every frame of the camera, whatever it is worth.
  void on_frame(const hal::Frame& frame, hal::TimeNs now);

  /// From now on it drives by this, which outlives it; nullptr: by its own map. Before the first frame.
  void share(SharedSight* shared) { shared_ = shared; }
  /// Blocks of what is shared have changed, though not by our own frames.
  void on_shared(std::span<const std::uint32_t> slots, hal::TimeNs now) {
    if (loops_ != nullptr && loops_->is_moving()) {
      navigator_.on_map_moving(shared_->map(), slots);
    } else {
      navigator_.on_map(shared_->map(), slots, {}, now);
    }
  }

  /// See Navigator::on_team() and team_word().
  void on_team(const TeamSight& sight, hal::TimeNs now) {
    team_ = sight;
    navigator_.on_team(sight, now);
  }
  [[nodiscard]] TeamWord team_word(hal::TimeNs now) const { return navigator_.team_word(now); }

  /// For people who look on.
  [[nodiscard]] LiveStatus status(hal::TimeNs now) const {
    return status_of(navigator_, driver_.state(), T_world_base(), now);
  }
  [[nodiscard]] hal::PlanarPose T_world_base() const;
  [[nodiscard]] const hal::kobuki::BaseState& base() const { return driver_.state(); }
  [[nodiscard]] hal::kobuki::BaseDriver& driver() { return driver_; }
  [[nodiscard]] const mapper::Mapper& mapper() const { return mapper_; }
  [[nodiscard]] Navigator& navigator() { return navigator_; }
  [[nodiscard]] const Navigator& navigator() const { return navigator_; }
  [[nodiscard]] const mapper::FrameCounts& frames() const { return frames_; }
  [[nodiscard]] const mapper::StageTimes& integrate_times() const { return integrate_times_; }
  [[nodiscard]] const mapper::StageTimes& align_times() const { return align_times_; }
  [[nodiscard]] const Placing& placing() const { return placing_; }
  [[nodiscard]] const mapper::StageTimes& loops_times() const { return loops_times_; }
  /// Nothing without loops.
  [[nodiscard]] const mapper::submaps::DrivingLoops* loops() const { return loops_.get(); }
  /// After the last frame: looks for loops once more, and puts the map right. For what is saved; it drives no more.
  void finish_map() {
    if (loops_ != nullptr) loops_->finish();
  }
  [[nodiscard]] const mapper::StageTimes& navigate_times() const { return navigate_times_; }
  [[nodiscard]] std::uint64_t pool_full_frames() const { return pool_full_frames_; }
  [[nodiscard]] std::uint64_t refused_blocks() const { return refused_blocks_; }
  /// Of the last frame that went into the map.
  [[nodiscard]] const std::optional<hal::Pose>& last_frame_pose() const { return last_frame_pose_; }

 private:
  /// Instead of mapping a frame. False: there is nothing to be moved.
  [[nodiscard]] bool moves_map(hal::TimeNs stamp_ns, hal::TimeNs now);
  void drop(hal::DropReason reason) { ++frames_.dropped[static_cast<std::size_t>(reason)]; }

  RobotConfig config_;
  hal::Clock& clock_;
  hal::kobuki::BaseDriver driver_;
  mapper::Mapper mapper_;
  Navigator navigator_;
  Senses senses_;
  Placing placing_;
  TeamSight team_;
  BodyMask body_mask_;
  std::unique_ptr<mapper::submaps::DrivingLoops> loops_;
  SharedSight* shared_ = nullptr;
  mapper::FrameCounts frames_;
  mapper::StageTimes integrate_times_;
  mapper::StageTimes align_times_;
  mapper::StageTimes loops_times_;
  mapper::StageTimes navigate_times_;
  std::uint64_t pool_full_frames_ = 0;
  std::uint64_t refused_blocks_ = 0;
  std::uint64_t packets_seen_ = 0;
  std::uint64_t ticks_ = 0;
  bool was_lost_ = false;
  std::optional<hal::Pose> last_frame_pose_;
};

}  // namespace g3d::nav
