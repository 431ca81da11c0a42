// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/openni_link.hpp"

#include <OpenNI.h>
#include <fmt/format.h>

#include <atomic>

#include "hal/kinect/openni/session.hpp"

namespace g3d::hal::kinect::openni {
namespace {

namespace oni = ::openni;

// libfreenect stamps images by the camera's own counter: 32 bits at 60 MHz.
constexpr double kFreenectTick_ns = 1000.0 / 60.0;
constexpr int kFreenectTickBits = 32;

class OpenNiLink final : public SensorLink, private oni::OpenNI::DeviceDisconnectedListener {
 public:
  OpenNiLink(const Clock& clock, const OpenNiOptions& options) : clock_(clock), options_(options) {}
  ~OpenNiLink() override { shut(); }
  OpenNiLink(const OpenNiLink&) = delete;
  OpenNiLink& operator=(const OpenNiLink&) = delete;

  Result<SensorInfo> open(ImageSink& sink) override {
    shut();
    auto session = Session::begin(options_.driver, sink, clock_);
    if (!session) return session.error();
    session_ = std::move(session).value();
    auto info = start();
    if (!info) shut();
    return info;
  }
  void close() override { shut(); }
  [[nodiscard]] bool is_lost() const override { return lost_.load(std::memory_order_acquire); }

 private:
  void onDeviceDisconnected(const oni::DeviceInfo* /*gone*/) override { lost_.store(true, std::memory_order_release); }

  Result<SensorInfo> start() {
    lost_.store(false, std::memory_order_release);
    oni::OpenNI::addDeviceDisconnectedListener(this);
    is_listening_ = true;
    if (device_.open(oni::ANY_DEVICE) != oni::STATUS_OK) {
      const std::string why = driver_text();
      return Error{Reason::not_found,
                   fmt::format("no Kinect can be opened: {}; is it plugged in, has it power (its own "
                               "supply), and may this user open USB devices?",
                               why)};
    }
    // Depth first: libfreenect's driver asks its depth stream what it can register.
    if (!create(depth_, oni::SENSOR_DEPTH, oni::PIXEL_FORMAT_DEPTH_1_MM)) return no_stream("depth");
    SensorInfo info;
    info.has_colour = create(colour_, oni::SENSOR_COLOR, oni::PIXEL_FORMAT_RGB888);
    info.is_registered = info.has_colour && register_depth();
    (void)depth_.setMirroringEnabled(false);
    if (info.has_colour) (void)colour_.setMirroringEnabled(false);
    // A driver that does not know the question did not mirror.
    info.is_mirrored = depth_.isPropertySupported(oni::STREAM_PROPERTY_MIRRORING) && depth_.getMirroringEnabled();
    info.horizontal_fov_rad = static_cast<double>(depth_.getHorizontalFieldOfView());
    info.name = fmt::format("{} {}", device_.getDeviceInfo().getVendor(), device_.getDeviceInfo().getName());
    if (options_.driver == Driver::freenect) {
      info.tick_ns = kFreenectTick_ns;
      info.tick_bits = kFreenectTickBits;
    }
    if (auto recording = begin_recording(info.has_colour); !recording) return recording.error();
    if (depth_.start() != oni::STATUS_OK) return no_stream("depth");
    if (info.has_colour && colour_.start() != oni::STATUS_OK) return no_stream("colour");
    return info;
  }

  bool create(oni::VideoStream& stream, oni::SensorType sensor, oni::PixelFormat format) {
    if (stream.create(device_, sensor) != oni::STATUS_OK) return false;
    oni::VideoMode mode;
    mode.setResolution(640, 480);
    mode.setFps(30);
    mode.setPixelFormat(format);
    (void)stream.setVideoMode(
        mode);  // some drivers have one mode and no choice: what comes is looked at image by image
    return true;
  }

  bool register_depth() {
    constexpr auto kMode = oni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
    return device_.isImageRegistrationModeSupported(kMode) &&
           device_.setImageRegistrationMode(kMode) == oni::STATUS_OK && device_.getImageRegistrationMode() == kMode;
  }

  Result<void> begin_recording(bool has_colour) {
    if (options_.record_path.empty()) return {};
    const std::string path = numbered_path(options_.record_path, ++recordings_);
    const auto refused = [&] {
      return Error{Reason::io_error, fmt::format("{}: cannot be recorded into: {}", path, openni_error())};
    };
    if (recorder_.create(path.c_str()) != oni::STATUS_OK) return refused();
    if (recorder_.attach(depth_) != oni::STATUS_OK) return refused();
    if (has_colour && recorder_.attach(colour_, true) != oni::STATUS_OK) return refused();
    if (recorder_.start() != oni::STATUS_OK) return refused();
    return {};
  }

  [[nodiscard]] std::string driver_text() const {
    const std::string text = openni_error();
    return text.empty() ? last_driver_exception() : text;
  }
  [[nodiscard]] Error no_stream(std::string_view what) const {
    return {Reason::io_error, fmt::format("the Kinect gives no {} images: {}", what, driver_text())};
  }

  void shut() {
    if (session_ == nullptr) return;
    Session::end_tap();
    if (recorder_.isValid()) recorder_.stop();
    if (depth_.isValid()) depth_.stop();
    if (colour_.isValid()) colour_.stop();
    recorder_.destroy();
    colour_.destroy();
    depth_.destroy();
    device_.close();
    if (is_listening_) oni::OpenNI::removeDeviceDisconnectedListener(this);
    is_listening_ = false;
    session_.reset();
  }

  const Clock& clock_;
  const OpenNiOptions options_;
  std::unique_ptr<Session> session_;
  oni::Device device_;
  oni::VideoStream depth_;
  oni::VideoStream colour_;
  oni::Recorder recorder_;
  std::uint64_t recordings_ = 0;
  bool is_listening_ = false;
  std::atomic<bool> lost_{false};
};

}  // namespace

std::unique_ptr<SensorLink> make_openni_link(const Clock& clock, const OpenNiOptions& options) {
  return std::make_unique<OpenNiLink>(clock, options);
}

std::string numbered_path(const std::string& path, std::uint64_t number) {
  if (number <= 1) return path;
  const std::size_t slash = path.find_last_of('/');
  const std::size_t dot = path.find_last_of('.');
  const bool has_ending = dot != std::string::npos && (slash == std::string::npos || dot > slash + 1);
  const std::string stem = has_ending ? path.substr(0, dot) : path;
  return fmt::format("{}-{}{}", stem, number, has_ending ? path.substr(dot) : "");
}

}  // namespace g3d::hal::kinect::openni
