// SPDX-License-Identifier: Apache-2.0
// The robot in real time, each part in a thread of its own:
//
//   camera thread ──judged frames, a ring──▶ mapper thread ══the map, in turns══▶ navigator thread
//        ▲  └─the camera sees─▶ base thread ◀──────command, latest value──────────────┘  ▲
//        └────odometry, latest value────┴───────────────odometry, latest value───────────┘
//
// A mapper that is behind loses the oldest waiting frame (queue_full), never the newest. After a frame the map belongs
// to the navigator until that has taken the changes over, then to the mapper again; so the navigator decides on time
// even while a frame is being mapped. It never waits for anybody. No locks; nothing allocates after the start but what
// the explorer reserved for itself.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/frame_pool.hpp"
#include "hal/kobuki/base_thread.hpp"
#include "hal/latest.hpp"
#include "hal/parking.hpp"
#include "hal/record/frame_recorder.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "hal/ring.hpp"
#include "mapper/mapper.hpp"
#include "mapper/report.hpp"
#include "mapper/stage_times.hpp"
#include "mapper/submaps/driving_loops.hpp"
#include "nav/body_mask.hpp"
#include "nav/hotline.hpp"
#include "nav/navigator.hpp"
#include "nav/placing.hpp"
#include "nav/robot.hpp"
#include "nav/senses.hpp"
#include "nav/shared_sight.hpp"
#include "nav/team_link.hpp"

namespace g3d::nav {

struct RobotThreadsConfig {
  RobotConfig robot;
  hal::kobuki::BaseThreadOptions base;           ///< its driver is the robot's
  std::size_t frames_waiting = 2;                ///< for the mapper, 1 or more
  hal::TimeNs poll_ns = 2'000'000;               ///< how often the navigator looks for a new map
  hal::TimeNs coverage_period_ns = 500'000'000;  ///< how often it is measured
  /// Ticked by these threads; the base's is among its own options. The camera's rests while it waits for a frame.
  hal::ProgressEntry* camera_progress = nullptr;
  hal::ProgressEntry* mapper_progress = nullptr;
  hal::ProgressEntry* navigator_progress = nullptr;
};

/// What the robot is made of. All outlive it; guard and recorder may be null.
struct RobotParts {
  hal::ByteLine& line;
  hal::DepthCamera& camera;
  hal::Clock& clock;
  std::function<void()> end_camera;  ///< makes the camera's read() return soon. Any thread
  hal::kobuki::LineGuard* guard = nullptr;
  hal::kobuki::LineRecorder* recorder = nullptr;
  /// 0..1 of what can be seen: for somebody who knows the building. May be empty. The navigator's thread.
  std::function<double(const GroundMap&)> coverage;
  /// Every frame that is in the map now; `masked`: as it was mapped, where that is not as it came. May be empty; must
  /// not wait. The mapper's thread.
  std::function<void(const hal::MappedNote&, const hal::Frame* masked)> on_mapped = {};
};

/// CPU time that each thread has used.
struct ThreadTime {
  const char* name;
  double cpu_s = 0.0;
};

class RobotThreads {
 public:
  RobotThreads(const RobotThreadsConfig& config, const RobotParts& parts);
  ~RobotThreads();
  RobotThreads(const RobotThreads&) = delete;
  RobotThreads& operator=(const RobotThreads&) = delete;

  /// From now on it drives by this, which outlives its threads; used by the navigator's thread alone, while the map is
  /// its own. `note_changed` is told of every frame's changed slots, by the mapper's thread; with loops not of
  /// what a correction has moved: that loops()->chain() says. Before start().
  void share(SharedSight& shared, std::function<void(std::span<const std::uint32_t> slots)> note_changed) {
    shared_ = &shared;
    note_changed_ = std::move(note_changed);
  }
  /// From now on it tells a team of itself, and goes by what that tells of the others. `link` outlives its threads.
  /// Before start().
  void join_team(TeamLink& link) { team_ = &link; }
  /// Once. It drives as soon as base and camera have proven themselves.
  void start();
  /// Zeros to the base first; then every frame under way goes into the map, and the threads end. Once stopped it is not
  /// started again.
  void stop();

  // While it runs
  [[nodiscard]] const hal::Latest<LiveStatus>& status() const { return hotline_.status(); }
  /// Where people's words go in.
  [[nodiscard]] Hotline& hotline() { return hotline_; }
  [[nodiscard]] hal::kobuki::BaseThread& base() { return base_; }
  /// Whether the camera has said that no frame will ever come again.
  [[nodiscard]] bool camera_has_ended() const { return camera_ended_.load(std::memory_order_acquire); }
  /// The pose of each frame that is in the map, in their order. One thread; if it comes too seldom, poses are lost.
  [[nodiscard]] bool next_pose(hal::StampedPose& pose) { return poses_.try_pop(pose); }

  // After stop()
  [[nodiscard]] mapper::FrameCounts frames() const;
  [[nodiscard]] std::vector<mapper::NamedStage> stages() const;
  /// Of the robot's own threads; what reading a frame from the camera costs stands by itself ("camera_read").
  [[nodiscard]] std::vector<ThreadTime> thread_times() const;
  [[nodiscard]] const mapper::Mapper& mapper() const { return mapper_; }
  [[nodiscard]] const Navigator& navigator() const { return navigator_; }
  [[nodiscard]] const Placing& placing() const { return placing_; }
  /// Nothing without loops. The map was put right once more by stop().
  [[nodiscard]] const mapper::submaps::DrivingLoops* loops() const { return loops_.get(); }
  [[nodiscard]] std::uint64_t pool_full_frames() const { return pool_full_frames_; }
  [[nodiscard]] std::uint64_t refused_blocks() const { return refused_blocks_; }
  [[nodiscard]] std::uint64_t lost_poses() const { return lost_poses_; }

 private:
  struct JudgedFrame {
    std::uint32_t frame_index = 0;
    Sight sight;
  };
  enum class Stage : std::uint8_t {
    read,            ///< camera: waiting for the frame included
    look,            ///< judging it
    loops,           ///< submaps, and parts of a correction of the map
    align,           ///< the pose that fits what was seen before
    integrate,       ///< frame -> map
    end_to_end,      ///< the frame's stamp -> map updated
    hand_over,       ///< map updated -> the navigator has taken the changes over
    ground,          ///< the navigator's part of that
    navigate,        ///< a step of the navigator
    navigate_late,   ///< by how much it came too late
    control_jitter,  ///< by how much the base's 20 ms tick came too late
    count_,
  };
  static constexpr std::size_t kStages = static_cast<std::size_t>(Stage::count_);
  [[nodiscard]] static const char* name_of(Stage stage);

  void camera_loop();
  void mapper_loop();
  /// It was given frames for longer than kLongestMapping_ns and has taken none: what the robot drives by is old.
  [[nodiscard]] bool mapper_is_stuck() const;
  void navigator_loop();
  void integrate(JudgedFrame& judged);
  [[nodiscard]] bool moves_map(hal::TimeNs stamp_ns);
  void hand_over();
  void take_base(hal::TimeNs now);
  void take_words(hal::TimeNs now);
  void take_map(hal::TimeNs now);
  void take_shared_map(hal::TimeNs now);
  void step(hal::TimeNs now);
  void talk_to_team(hal::TimeNs now);
  void tell(hal::TimeNs now);
  void drop(hal::DropReason reason);
  [[nodiscard]] mapper::StageTimes& times(Stage stage) { return times_[static_cast<std::size_t>(stage)]; }
  void add_time(Stage stage, hal::TimeNs start_ns) { times(stage).add(parts_.clock.now() - start_ns); }
  [[nodiscard]] hal::kobuki::BaseThreadOptions base_options();

  const RobotThreadsConfig config_;
  const RobotParts parts_;
  std::array<mapper::StageTimes, kStages> times_;  // each written by one thread
  hal::kobuki::BaseThread base_;
  Senses senses_;
  mapper::Mapper mapper_;
  Placing placing_;                                       // the mapper thread's
  std::unique_ptr<mapper::submaps::DrivingLoops> loops_;  // as well
  Navigator navigator_;
  SharedSight* shared_ = nullptr;
  std::function<void(std::span<const std::uint32_t>)> note_changed_;
  // The team: what the mapper leaves out of the map, and what the navigator knows.
  TeamLink* team_ = nullptr;
  BodyMask body_mask_;
  TeamSight mapped_team_;
  std::uint64_t mapped_team_seen_ = 0;
  TeamSight team_sight_;
  std::uint64_t team_sight_seen_ = 0;
  hal::TimeNs next_team_word_ns_ = 0;

  hal::FramePool pool_;
  hal::Ring<JudgedFrame> to_mapper_;
  hal::Parking mapper_waits_;
  std::atomic<bool> navigators_turn_{false};  // who may touch the map, its changes and shown_
  hal::Parking map_waits_;
  JudgedFrame shown_;
  enum class Showing : std::uint8_t { frame, map_moves, map_has_moved };
  Showing showing_ = Showing::frame;
  std::span<const std::uint32_t> moved_slots_;
  hal::Latest<hal::PlanarPose> T_world_odometry_;
  hal::Ring<hal::StampedPose> poses_;
  Hotline hotline_;

  std::atomic<bool> ending_{false}, navigator_ending_{false}, camera_ended_{false};
  std::atomic<std::uint64_t> delivered_{0}, integrated_{0};
  std::atomic<hal::TimeNs> mapper_given_ns_{0}, mapper_alive_ns_{0};  ///< 0: no frame yet
  std::array<std::atomic<std::uint64_t>, hal::kDropReasonCount> dropped_{};

  // The mapper thread's
  std::uint64_t pool_full_frames_ = 0, refused_blocks_ = 0, lost_poses_ = 0;
  // The navigator thread's
  std::uint64_t seen_state_ = 0, seen_packets_ = 0;
  hal::kobuki::BaseState base_state_;
  hal::PlanarPose astray_;  // T_world_odometry_, read last
  double coverage_ = -1.0;  // nobody knows
  hal::TimeNs next_coverage_ns_ = 0;

  // Written by each thread at its end
  std::int64_t camera_cpu_ns_ = 0, camera_read_cpu_ns_ = 0, mapper_cpu_ns_ = 0, navigator_cpu_ns_ = 0;
  std::thread camera_thread_, mapper_thread_, navigator_thread_;
};

}  // namespace g3d::nav
