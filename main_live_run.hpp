// SPDX-License-Identifier: Apache-2.0
// One real-time run of the board's robot: the port, the guard, the simulated building if the base is in one, the
// recorder and the threads; begun in the right order and ended in the right order.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.hpp"
#include "hal/linux/serial_port.hpp"
#include "hal/parking.hpp"
#include "hal/sim/disk_faults.hpp"
#include "hal/sim/observable.hpp"
#include "hal/sim/real_time_building.hpp"
#include "hal/stream/stream_camera.hpp"
#include "main_buses.hpp"
#include "main_commands.hpp"
#include "main_kinect.hpp"
#include "main_network.hpp"
#include "main_record.hpp"
#include "main_robot.hpp"
#include "main_service.hpp"
#include "nav/coverage.hpp"
#include "nav/exploration_report.hpp"
#include "nav/robot_threads.hpp"
#include "nav/team_link.hpp"

namespace g3d {

/// For a base without a camera: it stands, as nobody sees for it.
class NoCamera final : public hal::DepthCamera {
 public:
  explicit NoCamera(const hal::CameraModel& model) : model_(model) {}
  [[nodiscard]] const hal::CameraModel& model() const override { return model_; }
  [[nodiscard]] hal::CameraRead read(hal::Frame&) override {
    (void)waits_.wait([] { return false; });
    return {hal::CameraEvent::end, {}};
  }
  void stop() { waits_.stop(); }

 private:
  hal::CameraModel model_;
  hal::Parking waits_;
};

/// How the board file names a camera whose frames come out of a byte stream.
inline constexpr std::string_view kStreamSource = "stream:";

/// The simulated building before its time begins.
struct Place {
  hal::World world;
  hal::PlanarPose T_world_start;
  hal::Observable observable;
};

/// The world of the options. Errors name the file; bad_usage: of --start.
[[nodiscard]] hal::Result<Place> choose_place(const LiveOptions& options);

/// The members stand in the order in which they must go again: see LineGuard.
class LiveRun {
 public:
  /// All outlive this.
  LiveRun(const board::Board& board, const LiveOptions& options, const nav::RobotConfig& config,
          const Staging& staging);

  /// From now on it sees by this. Before begin().
  void use(std::unique_ptr<KinectPart> kinect) { kinect_ = std::move(kinect); }
  /// The guard's process first, then everything that has threads. `place`: where the base is simulated.
  /// `fleet`: that it shares its map with; none: it is alone.
  [[nodiscard]] hal::Result<void> begin(std::optional<Place> place, double rate_hz, std::optional<FleetPlan> fleet);
  /// Returns when it is home, its time is over, the camera has ended, or a signal came; then it stands, its fleet has
  /// been told as far as there was time, and all threads have ended.
  void run(bool show_progress);
  /// Ends the recording; it waits for the disk. Without one there is nothing to do.
  [[nodiscard]] hal::Result<void> finish_recording();

  // After run()
  [[nodiscard]] const nav::RobotThreads& robot() const { return *robot_; }
  [[nodiscard]] const BaseReport& base() const { return base_; }
  /// nullptr: it is alone.
  [[nodiscard]] const Fleet* fleet() const { return fleet_.get(); }
  /// Of the integrated frames.
  [[nodiscard]] const std::vector<hal::StampedPose>& way() const { return way_; }
  [[nodiscard]] double run_s() const { return run_s_; }
  [[nodiscard]] hal::TimeNs end_ns() const { return end_ns_; }
  [[nodiscard]] bool was_interrupted() const;
  /// What the simulated building knows; nothing without one.
  [[nodiscard]] std::optional<nav::OutsideView> outside();
  /// By how much its steps came too late, at most.
  [[nodiscard]] double building_late_s() const;
  /// Of the robot's threads, and of the process that holds the line too.
  [[nodiscard]] std::vector<nav::ThreadTime> thread_times() const;
  [[nodiscard]] const Buses& buses() const { return *buses_; }
  /// What people said.
  void write_control(mapper::JsonWriter& json) const { g3d::write_control(json, robot_->hotline(), control_counts_); }
  /// How the camera's stream did; nothing without one.
  void write_camera(mapper::JsonWriter& json) const;
  [[nodiscard]] std::string camera_error() const { return stream_camera_ ? stream_camera_->last_error() : ""; }
  [[nodiscard]] std::uint64_t unrecorded_bytes() const {
    return recording_ == nullptr ? 0 : recording_->line()->lost_bytes();
  }
  /// The recording is finished: `hash` of the map goes with it.
  void end_recording(const std::string& hash);
  void write_recording(mapper::JsonWriter& json) const {
    if (recording_ != nullptr) recording_->write(json, run_s_);
  }
  /// nullptr: it sees by something else.
  [[nodiscard]] const KinectPart* kinect() const { return kinect_.get(); }

 private:
  [[nodiscard]] hal::Result<std::string> find_port();
  [[nodiscard]] hal::Result<void> begin_recording();
  void record(nav::RobotParts& parts);
  [[nodiscard]] hal::DepthCamera& camera();
  void end_camera();
  void say_words(hal::TimeNs since_ns);
  [[nodiscard]] std::optional<std::string> answer(std::string_view request);
  void take_poses();
  void show(hal::TimeNs since_ns, const nav::LiveStatus& status) const;
  void note_base();

  const board::Board& board_;
  const LiveOptions& options_;
  const nav::RobotConfig& config_;
  const Staging& staging_;
  hal::SlowClock clock_;
  hal::TimeNs begin_ns_ = 0;
  std::optional<hal::DiskFaults> bad_disk_;
  std::optional<hal::DiskInstead> disk_instead_;
  hal::Observable observable_;
  std::optional<nav::CoverageMeter> meter_;
  std::unique_ptr<hal::RealTimeBuilding> building_;
  std::unique_ptr<hal::RealTimeBuilding::Camera> sim_camera_;
  std::unique_ptr<hal::StreamCamera> stream_camera_;
  std::unique_ptr<KinectPart> kinect_;  // may show what the one above sees
  hal::SerialPort port_;
  std::optional<hal::kobuki::LineGuard> guard_;
  NoCamera no_camera_;
  ServiceReport service_;
  std::unique_ptr<RunRecording> recording_;
  nav::TeamLink team_link_;
  std::unique_ptr<Buses> buses_;
  std::unique_ptr<nav::RobotThreads> robot_;
  std::unique_ptr<Fleet> fleet_;
  std::unique_ptr<hal::ControlSocket> control_;
  hal::ControlCounts control_counts_;
  std::size_t next_word_ = 0;

  std::vector<hal::StampedPose> way_;
  BaseReport base_;
  double run_s_ = 0.0;
  hal::TimeNs end_ns_ = 0;
};

}  // namespace g3d
