// SPDX-License-Identifier: Apache-2.0
// Control transfers to one USB device, as the Kinect's motor wants them: the seam between its protocol and libusb.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "hal/result.hpp"

namespace g3d::hal::kinect {

/// One thread. Calls may wait for a second.
class UsbControl {
 public:
  virtual ~UsbControl() = default;
  /// Vendor request to the device. False: it did not take it, or is gone.
  [[nodiscard]] virtual bool write(std::uint8_t request, std::uint16_t value) = 0;
  /// The same from the device: how many bytes it sent, at most as many as fit; -1: none, or it is gone.
  [[nodiscard]] virtual int read(std::uint8_t request, std::span<std::uint8_t> into) = 0;
};

/// The first device of that vendor and product. Errors: not_found, no_permission, unsupported (this machine has no USB,
/// or the program was built without libusb), io_error.
[[nodiscard]] Result<std::unique_ptr<UsbControl>> open_usb_control(std::uint16_t vendor, std::uint16_t product);

}  // namespace g3d::hal::kinect
