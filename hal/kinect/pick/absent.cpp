// SPDX-License-Identifier: Apache-2.0
// Built without OpenNI2 and libusb.
#include "hal/kinect/openni_parts.hpp"
#include "hal/kinect/usb_control.hpp"

namespace g3d::hal::kinect {
namespace {

Error not_built_in() {
  return {Reason::unsupported,
          "this g3dmap was built without OpenNI2, so it knows no Kinect and plays no .oni files; type "
          "scripts/static_libs where its sources are, and build it again"};
}

}  // namespace

bool is_openni_built_in() { return false; }

Result<std::unique_ptr<SensorLink>> make_freenect_link(const Clock&, const std::string&) { return not_built_in(); }

Result<std::unique_ptr<SensorLink>> make_virtual_link(Clock&, const std::string&, DepthCamera&, double) {
  return not_built_in();
}

Result<std::unique_ptr<DepthCamera>> open_recording(const std::string&, const Calibration*) { return not_built_in(); }

Result<std::unique_ptr<UsbControl>> open_usb_control(std::uint16_t, std::uint16_t) { return not_built_in(); }

}  // namespace g3d::hal::kinect
