// SPDX-License-Identifier: Apache-2.0
// A board's Kinect, `camera.source = "kinect"`, or a recording in its place, "oni:FILE": opened and levelled before the
// robot is made, as its intrinsics and its attitude are the robot's.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "board/board.hpp"
#include "hal/clock.hpp"
#include "hal/depth_camera.hpp"
#include "hal/kinect/kinect_camera.hpp"
#include "hal/kinect/tilt_unit.hpp"
#include "hal/result.hpp"
#include "mapper/json_writer.hpp"
#include "nav/live_status.hpp"

namespace g3d {

inline constexpr std::string_view kOniSource = "oni:";
[[nodiscard]] bool is_kinect(const board::Board& board);

/// The camera and its foot. Main thread, except for what says otherwise.
class KinectPart {
 public:
  /// Writes into `board` what was measured: intrinsics, mounting angles. A Kinect that is not there yet is no error, as
  /// it may come; nor is a foot that is absent. With a simulated base it is the virtual Kinect, which shows() something
  /// later. `record_path`: an .oni file, or empty. Errors: those of the calibration file and of the recording, and
  /// unsupported (not built in).
  [[nodiscard]] static hal::Result<std::unique_ptr<KinectPart>> open(board::Board& board,
                                                                     const std::string& record_path);
  ~KinectPart();
  KinectPart(const KinectPart&) = delete;
  KinectPart& operator=(const KinectPart&) = delete;

  /// What a virtual Kinect is to show; it outlives this. Does nothing for a real one.
  void show(hal::DepthCamera& shown);
  [[nodiscard]] hal::DepthCamera& camera();
  /// Its read() returns soon. Any thread.
  void end();
  /// The light says how the robot is: green while it drives by itself, blinking while it waits, yellow at home, red
  /// when it needs help.
  void light_up(const nav::LiveStatus& status);
  /// What people should know, from the start and from the run.
  [[nodiscard]] std::vector<std::string> notes() const;
  /// Writes the key "kinect" and the object.
  void write(mapper::JsonWriter& json) const;

 private:
  KinectPart() = default;
  void level(board::Board& board, const hal::kinect::Calibration& calibration);
  void set_light(hal::kinect::Light light);

  hal::RealClock clock_;
  bool is_virtual_ = false;
  double rate_hz_ = 30.0;
  std::string record_path_;
  hal::kinect::Calibration calibration_;
  std::unique_ptr<hal::kinect::TiltUnit> foot_;
  hal::kinect::Light light_ = hal::kinect::Light::off;
  bool has_light_ = false;
  std::unique_ptr<hal::kinect::KinectCamera> kinect_;
  std::unique_ptr<hal::DepthCamera> recording_;  ///< in its place
  std::unique_ptr<hal::DepthCamera> paced_;      ///< the recording at its own speed
  std::vector<std::string> notes_;
};

}  // namespace g3d
