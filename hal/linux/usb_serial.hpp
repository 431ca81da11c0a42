// SPDX-License-Identifier: Apache-2.0
// Which serial port is the robot's base: the one whose USB device says so by its product or serial string. Vendor and
// product numbers would also match any other FTDI cable. Reads sysfs alone and opens no device.
#pragma once

#include <string>

#include "hal/result.hpp"

namespace g3d::hal {

/// A device fits if one of the two that are not empty fits.
struct UsbSerialMatch {
  std::string product = "iClebo Kobuki";  ///< the whole product string
  std::string serial_prefix = "kobuki";   ///< how the serial string begins; the whole one tells two bases apart
};

struct UsbSerialDevice {
  std::string path;  ///< "/dev/ttyUSB0"
  std::string product;
  std::string serial;
  int latency_timer_ms = -1;  ///< how long the adapter collects bytes; -1 if the driver does not say
};

/// Any thread; allocates, reads some small files. `sys_root` and `dev_root` are "/sys" and "/dev" but in tests.
/// Errors: not_found (none fits; the text lists those that are there), bad_usage (several fit).
[[nodiscard]] Result<UsbSerialDevice> find_usb_serial(const UsbSerialMatch& match, const std::string& sys_root = "/sys",
                                                      const std::string& dev_root = "/dev");

}  // namespace g3d::hal
