// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/oni_camera.hpp"

#include <OpenNI.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "hal/clock.hpp"
#include "hal/kinect/colour_picker.hpp"
#include "hal/kinect/depth_table.hpp"
#include "hal/kinect/image_intake.hpp"
#include "hal/kinect/openni/session.hpp"

namespace g3d::hal::kinect::openni {
namespace {

namespace oni = ::openni;

// The player itself looks at its trigger every two seconds.
constexpr int kFrame_ms = 5000;
constexpr TimeNs kColourWithin_ns = 34'000'000;

CameraModel model_of(const OniFile& file, const OniCameraOptions& options) {
  CameraModel model = options.has_calibration ? colour_model(options.calibration) : CameraModel{};
  const double half_width_px = 0.5 * file.depth.width_px;
  if (!options.has_calibration && file.depth.horizontal_fov_rad > 0.0) {
    model.fx_px = model.fy_px = static_cast<float>(half_width_px / std::tan(0.5 * file.depth.horizontal_fov_rad));
  }
  model.width_px = file.depth.width_px;
  model.height_px = file.depth.height_px;
  // Calibrations are of 640 x 480.
  const float scale = static_cast<float>(file.depth.width_px) / 640.0F;
  if (options.has_calibration) {
    model.fx_px *= scale;
    model.fy_px *= scale;
  }
  if (!options.has_calibration || scale != 1.0F) {
    model.cx_px = static_cast<float>(half_width_px - 0.5);
    model.cy_px = static_cast<float>(0.5 * file.depth.height_px - 0.5);
  }
  return model;
}

class OniCamera final : public DepthCamera {
 public:
  OniCamera(std::string path, const OniFile& file, const OniCameraOptions& options)
      : path_(std::move(path)),
        file_(file),
        options_(options),
        model_(model_of(file, options)),
        depth_table_(options.calibration),
        intake_(file.depth.width_px, file.depth.height_px),
        colours_(intake_) {}
  ~OniCamera() override {
    if (session_ == nullptr) return;
    Session::end_tap();
    for (oni::VideoStream* stream : streams_) stream->stop();
    colour_stream_.destroy();
    depth_stream_.destroy();
    device_.close();
  }
  OniCamera(const OniCamera&) = delete;
  OniCamera& operator=(const OniCamera&) = delete;

  Result<void> open() {
    auto session = Session::begin(Driver::oni_file, intake_, clock_);
    if (!session) return session.error();
    session_ = std::move(session).value();
    const auto refused = [&](std::string_view what) {
      return Error{Reason::io_error, fmt::format("{}: OpenNI2 cannot play it ({}): {}", path_, what, openni_error())};
    };
    if (device_.open(path_.c_str()) != oni::STATUS_OK) return refused("open");
    oni::PlaybackControl* const playback = device_.getPlaybackControl();
    if (playback == nullptr) return refused("control");
    // A frame at a time, when one is asked for.
    if (playback->setSpeed(-1.0F) != oni::STATUS_OK) return refused("speed");
    (void)playback->setRepeatEnabled(false);
    if (depth_stream_.create(device_, oni::SENSOR_DEPTH) != oni::STATUS_OK) return refused("depth");
    streams_.push_back(&depth_stream_);
    if (file_.has_colour()) {
      if (colour_stream_.create(device_, oni::SENSOR_COLOR) != oni::STATUS_OK) return refused("colour");
      streams_.push_back(&colour_stream_);
    }
    for (oni::VideoStream* stream : streams_) {
      if (stream->start() != oni::STATUS_OK) return refused("start");
    }
    return {};
  }

  [[nodiscard]] const CameraModel& model() const override { return model_; }
  [[nodiscard]] std::optional<std::size_t> frame_count() const override { return file_.depth.frames; }
  [[nodiscard]] std::string last_error() const override { return last_error_; }

  [[nodiscard]] CameraRead read(Frame& out) override {
    ImageIntake::Taken depth;
    while (!intake_.try_take(ImageKind::depth, depth)) {
      if (depth_frames_ == file_.depth.frames) return {CameraEvent::end, {}};
      if (!play_on()) {
        last_error_ = fmt::format("{}: depth image {} of {} did not come; the rest is not played", path_,
                                  depth_frames_ + 1, file_.depth.frames);
        depth_frames_ = file_.depth.frames;
        return {CameraEvent::end, {}};
      }
    }
    ++depth_frames_;
    out.sequence = depth.index;
    out.stamp_ns = static_cast<TimeNs>(depth.device_ticks) * 1000;
    out.has_colour = false;
    if (depth.fault != ImageFault::none) {
      intake_.release(ImageKind::depth, depth);
      last_error_ = fmt::format("{}: depth image {}: {}", path_, depth.index, to_string(depth.fault));
      return {CameraEvent::dropped, DropReason::unreadable_depth};
    }
    fill_depth(intake_.depth(depth), out.depth.get());
    intake_.release(ImageKind::depth, depth);
    add_colour(depth.device_ticks, out);
    return {CameraEvent::frame, {}};
  }

 private:
  bool play_on() {
    int index = 0;
    if (oni::OpenNI::waitForAnyStream(streams_.data(), static_cast<int>(streams_.size()), &index, kFrame_ms) !=
        oni::STATUS_OK) {
      return false;
    }
    // The tap has had it; taken out of the core, or that would not ask for the next one.
    oni::VideoFrameRef seen;
    return streams_[static_cast<std::size_t>(index)]->readFrame(&seen) == oni::STATUS_OK;
  }

  [[nodiscard]] bool turns_round(bool is_mirrored) const { return is_mirrored && !options_.keeps_mirrored; }

  void fill_depth(const std::uint16_t* recorded_mm, std::uint16_t* out_mm) const {
    const std::size_t count = model_.pixel_count();
    if (options_.has_calibration) {
      depth_table_.apply(recorded_mm, count, out_mm);
    } else {
      std::copy_n(recorded_mm, count, out_mm);
    }
    if (!turns_round(file_.depth.is_mirrored)) return;
    const auto width = static_cast<std::size_t>(model_.width_px);
    for (std::size_t row = 0; row < count; row += width) std::reverse(out_mm + row, out_mm + row + width);
  }

  void add_colour(std::uint64_t depth_us, Frame& out) {
    const std::uint8_t* const rgb = colours_.pick(depth_us, kColourWithin_ns);
    if (rgb == nullptr) return;
    const auto width = static_cast<std::size_t>(model_.width_px);
    if (turns_round(file_.colour.is_mirrored)) {
      for (std::size_t i = 0; i < model_.pixel_count(); ++i) {
        std::memcpy(out.rgb.get() + 3 * i, rgb + 3 * (i + width - 1 - 2 * (i % width)), 3);
      }
    } else {
      std::memcpy(out.rgb.get(), rgb, 3 * model_.pixel_count());
    }
    out.has_colour = true;
  }

  const std::string path_;
  const OniFile file_;
  const OniCameraOptions options_;
  const CameraModel model_;
  const DepthTable depth_table_;
  const RealClock clock_;  // nobody asks when an image was played
  ImageIntake intake_;
  ColourPicker colours_;
  std::unique_ptr<Session> session_;
  oni::Device device_;
  oni::VideoStream depth_stream_;
  oni::VideoStream colour_stream_;
  std::vector<oni::VideoStream*> streams_;
  std::size_t depth_frames_ = 0;  // that have been read
  std::string last_error_;
};

}  // namespace

Result<std::unique_ptr<DepthCamera>> open_oni_camera(const std::string& path, const OniCameraOptions& options) {
  const auto file = check_oni_file(path);
  if (!file) return file.error();
  auto camera = std::make_unique<OniCamera>(path, file.value(), options);
  if (auto opened = camera->open(); !opened) return opened.error();
  return std::unique_ptr<DepthCamera>(std::move(camera));
}

}  // namespace g3d::hal::kinect::openni
