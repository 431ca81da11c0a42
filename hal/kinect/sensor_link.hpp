// SPDX-License-Identifier: Apache-2.0
// The seam between a Kinect and what makes frames of its images: who opens the sensor, and who takes what it sends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal::kinect {

/// The one size of image that we ask a Kinect for.
inline constexpr int kWidth_px = 640;
inline constexpr int kHeight_px = 480;

enum class ImageKind : std::uint8_t { depth, colour };

/// One image as a driver hands it over; valid during the call alone. Depth: uint16 millimetres, 0 = no reading, in the
/// machine's byte order. Colour: R G B.
struct SensorImage {
  ImageKind kind = ImageKind::depth;
  int width_px = 0;
  int height_px = 0;
  int stride_bytes = 0;
  bool is_known_format = true;  ///< the bytes are what is said above
  std::span<const std::uint8_t> bytes;
  std::uint64_t device_ticks = 0;  ///< the sensor's clock; see SensorInfo::tick_ns
  std::uint32_t index = 0;         ///< counted by the sensor, gaps are images that it lost
  TimeNs arrived_ns = 0;
};

/// Called from threads of a driver, for each kind of image from one at a time. Must not wait.
class ImageSink {
 public:
  virtual ~ImageSink() = default;
  virtual void take(const SensorImage& image) = 0;
};

/// What was opened.
struct SensorInfo {
  std::string name;
  bool has_colour = true;
  bool is_registered = false;       ///< depth pixels lie where the colour camera sees the same point
  bool is_mirrored = false;         ///< left and right are exchanged
  double tick_ns = 1000.0;          ///< of device_ticks
  int tick_bits = 64;               ///< where they begin again
  double horizontal_fov_rad = 0.0;  ///< of the depth image; 0: not said
};

/// One thread.
class SensorLink {
 public:
  virtual ~SensorLink() = default;
  /// Looks for the sensor and starts it; images go to `sink` until close(). May take seconds. Errors: not_found (none
  /// is plugged in), no_permission, unsupported, io_error.
  [[nodiscard]] virtual Result<SensorInfo> open(ImageSink& sink) = 0;
  /// No thread is in `sink` any more afterwards. Also when it was never opened.
  virtual void close() = 0;
  /// Whether the driver has said that the sensor is gone. Drivers that do not notice are found out by their silence.
  [[nodiscard]] virtual bool is_lost() const = 0;
};

}  // namespace g3d::hal::kinect
