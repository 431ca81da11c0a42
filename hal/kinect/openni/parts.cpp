// SPDX-License-Identifier: Apache-2.0
// Built with OpenNI2.
#include "hal/kinect/openni/oni_camera.hpp"
#include "hal/kinect/openni/openni_link.hpp"
#include "hal/kinect/openni/virtual_kinect.hpp"
#include "hal/kinect/openni_parts.hpp"

namespace g3d::hal::kinect {
namespace {

class VirtualLink final : public SensorLink {
 public:
  VirtualLink(Clock& clock, const std::string& record_path, DepthCamera& shown, double rate_hz)
      : device_([&shown](std::uint64_t /*number*/, Frame& out) { return shown.read(out).event == CameraEvent::frame; },
                clock, openni::VirtualKinectOptions{.rate_hz = rate_hz}),
        link_(openni::make_openni_link(clock, {openni::Driver::virtual_kinect, record_path})) {}
  Result<SensorInfo> open(ImageSink& sink) override { return link_->open(sink); }
  void close() override { link_->close(); }
  [[nodiscard]] bool is_lost() const override { return link_->is_lost(); }

 private:
  openni::VirtualKinect device_;
  std::unique_ptr<SensorLink> link_;
};

}  // namespace

bool is_openni_built_in() { return true; }

Result<std::unique_ptr<SensorLink>> make_freenect_link(const Clock& clock, const std::string& record_path) {
  return openni::make_openni_link(clock, {openni::Driver::freenect, record_path});
}

Result<std::unique_ptr<SensorLink>> make_virtual_link(Clock& clock, const std::string& record_path, DepthCamera& shown,
                                                      double rate_hz) {
  return std::unique_ptr<SensorLink>(std::make_unique<VirtualLink>(clock, record_path, shown, rate_hz));
}

Result<std::unique_ptr<DepthCamera>> open_recording(const std::string& path, const Calibration* calibration) {
  openni::OniCameraOptions options;
  options.has_calibration = calibration != nullptr;
  if (calibration != nullptr) options.calibration = *calibration;
  return openni::open_oni_camera(path, options);
}

}  // namespace g3d::hal::kinect
