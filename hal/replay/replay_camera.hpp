// SPDX-License-Identifier: Apache-2.0
// A recorded folder in place of a camera. Images are read and decoded by the thread that calls read().
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/image/jpeg_reader.hpp"
#include "hal/image/png_reader.hpp"
#include "hal/record/packed_image.hpp"
#include "hal/replay/tum_folder.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

class ReplayCamera final : public DepthCamera {
 public:
  static Result<std::unique_ptr<ReplayCamera>> open(const std::string& folder);
  explicit ReplayCamera(TumFolder log);

  [[nodiscard]] const CameraModel& model() const override { return log_.camera; }
  /// One entry of depth.txt per call. A frame whose colour image is missing, broken or of another size comes without
  /// colour. Depth PNGs are decoded without allocation; JPEG colour allocates within libjpeg.
  [[nodiscard]] CameraRead read(Frame& out) override;
  [[nodiscard]] std::optional<std::size_t> frame_count() const override { return log_.frames.size(); }
  [[nodiscard]] std::string last_error() const override { return last_error_; }

  /// What the folder lacked when it was opened.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return log_.warnings; }
  /// Frames delivered without colour because their image was missing or broken; last_error() tells of the last.
  [[nodiscard]] std::uint64_t broken_colours() const { return broken_colours_; }
  /// Frames delivered without colour because rgb.txt has none near enough in time.
  [[nodiscard]] std::uint64_t unmatched_colours() const { return unmatched_colours_; }

 private:
  Result<void> read_depth(const RecordedFrame& recorded, Frame& out);
  bool read_colour(const RecordedFrame& recorded, Frame& out);
  Result<void> decode_colour(const std::string& path, Frame& out);

  TumFolder log_;
  std::size_t next_ = 0;
  std::optional<TimeNs> newest_ns_;
  std::uint64_t broken_colours_ = 0;
  std::uint64_t unmatched_colours_ = 0;
  std::string last_error_;

  PngReader png_;
  JpegReader jpeg_;
  ImageUnpacker packed_;
  std::vector<std::uint8_t> file_;  // the image file of the moment; keeps its capacity
};

}  // namespace g3d::hal
