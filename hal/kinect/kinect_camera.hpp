// SPDX-License-Identifier: Apache-2.0
// A live Kinect as a DepthCamera: 640 x 480 depth registered to colour. A sensor that is pulled out, falls silent or
// was never there is looked for again and again, at growing intervals; meanwhile read() waits, and the robot stands as
// no frame tells it that it sees. Driver's threads bring the images, the camera thread makes frames of them.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/depth_camera.hpp"
#include "hal/kinect/calibration.hpp"
#include "hal/kinect/colour_picker.hpp"
#include "hal/kinect/depth_registration.hpp"
#include "hal/kinect/depth_table.hpp"
#include "hal/kinect/image_intake.hpp"
#include "hal/kinect/sensor_link.hpp"
#include "hal/kinect/sensor_stamps.hpp"
#include "hal/latest.hpp"

namespace g3d::hal::kinect {

struct KinectOptions {
  Calibration calibration;
  TimeNs stall_ns = 1'500'000'000;        ///< without a depth image for so long the sensor is opened anew
  TimeNs first_image_ns = 5'000'000'000;  ///< the first one after opening may take so long
  TimeNs first_retry_ns = 250'000'000;    ///< doubled after every failure ...
  TimeNs last_retry_ns = 4'000'000'000;   ///< ... up to this
  TimeNs poll_ns = 2'000'000;             ///< how often the camera thread looks for an image
  TimeNs colour_within_ns = 34'000'000;   ///< a colour image belongs to a depth image that is not farther away in time
};

/// What has happened so far.
struct KinectCounts {
  std::uint64_t opened = 0;
  std::uint64_t open_failures = 0;
  std::uint64_t unplugged = 0;  ///< the driver said so
  std::uint64_t stalled = 0;    ///< it fell silent
  std::uint64_t frames = 0;
  std::uint64_t colourless = 0;  ///< of the frames
  std::uint64_t missed = 0;      ///< gaps in the sensor's own numbers
  std::uint64_t doubtful_stamps = 0;
  std::uint64_t bad_depth = 0, bad_colour = 0;            ///< half images and the like
  std::uint64_t depth_overruns = 0, colour_overruns = 0;  ///< the camera thread was behind
  bool is_open = false;
};

class KinectCamera final : public DepthCamera {
 public:
  /// Opens nothing yet. `clock` outlives this.
  KinectCamera(std::unique_ptr<SensorLink> link, Clock& clock, const KinectOptions& options);
  ~KinectCamera() override;
  KinectCamera(const KinectCamera&) = delete;
  KinectCamera& operator=(const KinectCamera&) = delete;

  /// Opens it now, so that what is wrong can be said at the start. Before read(); without it read() does.
  [[nodiscard]] Result<void> open();

  [[nodiscard]] const CameraModel& model() const override { return model_; }
  /// Waits for the next depth image, however long that takes. Allocates nothing while the sensor is there.
  [[nodiscard]] CameraRead read(Frame& out) override;
  /// Why it was last lost or could not be opened. The camera thread.
  [[nodiscard]] std::string last_error() const override { return last_error_; }

  /// read() says `end` soon, from now on. Any thread.
  void stop() { stopped_.store(true, std::memory_order_release); }
  /// Any thread.
  [[nodiscard]] KinectCounts counts() const;

 private:
  void lose(std::string reason);
  void try_to_open();
  [[nodiscard]] std::optional<CameraRead> take_depth(Frame& out);
  void add_colour(std::uint64_t depth_ticks, Frame& out);
  void fill_depth(const std::uint16_t* reported_mm, std::uint16_t* out_mm);
  void publish();

  const std::unique_ptr<SensorLink> link_;
  Clock& clock_;
  const KinectOptions options_;
  const CameraModel model_;
  ImageIntake intake_;
  ColourPicker colours_;  // the camera thread's
  DepthTable depth_table_;
  DepthRegistration registration_;
  std::vector<std::uint16_t> corrected_mm_;  // before it is registered

  std::atomic<bool> stopped_{false};
  // The camera thread's
  bool is_open_ = false;
  SensorInfo sensor_;
  std::optional<SensorStamps> stamps_;
  TimeNs opened_ns_ = 0;
  TimeNs last_image_ns_ = 0;  // 0: none since it was opened
  TimeNs next_try_ns_ = 0;
  TimeNs retry_ns_ = 0;
  TimeNs last_stamp_ns_ = 0;
  bool has_stamp_ = false;
  std::optional<std::uint32_t> last_index_;
  std::uint64_t sequence_ = 0;
  std::string last_error_;
  KinectCounts counts_;
  Latest<KinectCounts> published_;
};

}  // namespace g3d::hal::kinect
