// SPDX-License-Identifier: Apache-2.0
// From the camera to the map, one thread per step, joined by rings:
//
//   camera thread ──index──▶ pose thread ──posed index──▶ mapper thread ──what was mapped──▶ writer thread
//                            (aligns it, if asked)
//        ▲                                                      │
//        └───────────────────── free frames ────────────────────┘
//
// Lockstep: every step waits for the next, nothing is dropped for lack of time, the same data give the same map.
// Real time: a frame is released when the clock says so, and dropped (queue_full) if all frames are under way.
// Every frame that the camera delivered is either integrated or counted under one reason. After start nothing here
// allocates, locks a mutex or touches a file; what the camera and the sink do is theirs.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "hal/clock.hpp"
#include "hal/depth_camera.hpp"
#include "hal/frame_pool.hpp"
#include "hal/messages.hpp"
#include "hal/parking.hpp"
#include "hal/ring.hpp"
#include "mapper/mapper.hpp"
#include "mapper/report.hpp"
#include "mapper/stage_times.hpp"

namespace g3d::mapper {

class RollingWindow;
namespace align {
class Aligner;
}
namespace submaps {
class LoopedMap;
}

/// One frame that is in the map now.
struct MappedFrame {
  hal::TimeNs stamp_ns = 0;
  hal::Pose T_world_camera;
  hal::Pose T_odometry_camera;  ///< as the source gave it; the same if nothing aligns
  FrameReport report;
};

struct Progress {
  std::uint64_t delivered = 0;
  std::uint64_t integrated = 0;
  std::uint64_t dropped = 0;
};

/// Who is told. Nothing here may throw.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// Writer thread, in order of integration. May be slow: the mapper waits only once 64 frames are waiting here.
  virtual void on_frame(const MappedFrame& frame) = 0;
  /// The thread that called run(), about ten times a second.
  virtual void on_progress(const Progress& progress) = 0;
};

/// The robot stands where it starts, so that place is free: its cylinder, wherever the first frame's pose puts it.
struct StartFootprint {
  double radius_m = 0.0;
  double height_m = 0.0;
  hal::Pose T_base_camera;
};

struct PipelineConfig {
  double rate = 0.0;                ///< 0: lockstep. Else real time, the data's clock running this many times as fast
  int frames_under_way = 4;         ///< 1..64, besides the one that the camera is filling
  RollingWindow* window = nullptr;  ///< if the map may be larger than memory; its lockstep must be ours
  std::optional<StartFootprint> footprint = std::nullopt;
  /// Corrects every pose before its frame is integrated: in the pose thread, or in the mapper's if a card does it.
  align::Aligner* aligner = nullptr;
  /// Instead of an aligner and a window: the same in the mapper's thread, and the whole map is corrected now and then.
  /// Allocates, and waits for the disk if it has a window of its own.
  submaps::LoopedMap* looped = nullptr;
};

enum class Stage : std::uint8_t {
  read,        ///< camera: file or driver -> frame
  pose,        ///< stamp -> pose
  align,       ///< pose -> pose that fits what was seen before
  integrate,   ///< posed frame -> map updated
  loops,       ///< submaps, and what is seen again
  write,       ///< the sink
  end_to_end,  ///< frame complete -> map updated, waiting included
  count_,
};
inline constexpr std::size_t kStageCount = static_cast<std::size_t>(Stage::count_);
[[nodiscard]] const char* to_string(Stage stage);

class Pipeline {
 public:
  /// All references outlive the pipeline. `clock` paces real time and times the stages.
  Pipeline(hal::DepthCamera& camera, const hal::PoseSource& poses, Mapper& mapper, FrameSink& sink, hal::Clock& clock,
           const PipelineConfig& config);

  /// Starts the threads and returns when the camera has ended, or request_stop() was called, and all that was under
  /// way is in the map. Once only.
  void run();

  /// Any thread or signal handler: no further frame is read, those under way are finished.
  void request_stop() { stop_requested_.store(true, std::memory_order_relaxed); }

  // After run()
  [[nodiscard]] FrameCounts frames() const;
  [[nodiscard]] const StageTimes& times(Stage stage) const { return times_[static_cast<std::size_t>(stage)]; }
  [[nodiscard]] bool was_interrupted() const { return interrupted_; }
  [[nodiscard]] std::uint64_t pool_full_frames() const { return pool_full_frames_; }
  [[nodiscard]] std::uint64_t refused_blocks() const { return refused_blocks_; }

 private:
  struct PosedMessage {
    hal::PosedFrame posed;
    hal::Pose T_odometry_camera;
    bool usable = false;  ///< false: counted as dropped, on its way back to the pool
  };

  void camera_loop();
  void pose_loop();
  void mapper_loop();
  void writer_loop();
  /// False if asked to stop while waiting.
  bool wait_until_due(hal::TimeNs stamp_ns);

  std::optional<hal::DropReason> find_pose(hal::TimeNs stamp_ns, hal::Pose& T_world_camera);
  void integrate(const PosedMessage& message);
  /// The part of integrate() that aligns, if this is the thread for it.
  void align_here(const hal::Frame& frame, MappedFrame& mapped);
  void drop(hal::DropReason reason);
  void add_time(Stage stage, hal::TimeNs start_ns);
  [[nodiscard]] bool is_lockstep() const { return config_.rate <= 0.0; }
  [[nodiscard]] Progress progress() const;

  hal::DepthCamera& camera_;
  const hal::PoseSource& poses_;
  Mapper& mapper_;
  FrameSink& sink_;
  hal::Clock& clock_;
  PipelineConfig config_;

  hal::FramePool pool_;
  std::unique_ptr<hal::TimeNs[]> read_at_ns_;  ///< per frame of the pool: when the camera had completed it
  hal::Ring<std::uint32_t> to_pose_;
  hal::Ring<PosedMessage> to_mapper_;
  hal::Ring<MappedFrame> to_writer_;
  hal::Parking camera_parking_, pose_parking_, mapper_parking_, writer_parking_, writer_room_parking_;

  std::atomic<bool> stop_requested_{false};
  bool interrupted_ = false;                                                 // camera thread
  bool footprint_freed_ = false;                                             // mapper thread
  std::optional<hal::TimeNs> last_stamp_ns_;                                 // pose thread
  std::optional<hal::TimeNs> schedule_stamp_ns_;                             // camera thread: this stamp was due ...
  hal::TimeNs schedule_start_ns_ = 0;                                        // ... at this time
  std::uint64_t pool_full_frames_ = 0;                                       // mapper thread
  std::uint64_t refused_blocks_ = 0;                                         // mapper thread
  std::array<StageTimes, kStageCount> times_;                                // each written by its own thread
  std::atomic<std::uint64_t> delivered_{0};                                  // camera thread
  std::atomic<std::uint64_t> integrated_{0};                                 // mapper thread
  std::array<std::atomic<std::uint64_t>, hal::kDropReasonCount> dropped_{};  // any thread of the pipeline
};

}  // namespace g3d::mapper
