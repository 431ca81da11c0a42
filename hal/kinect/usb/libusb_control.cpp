// SPDX-License-Identifier: Apache-2.0
// By libusb.
#include <fmt/format.h>
#include <libusb.h>

#include "hal/kinect/usb_control.hpp"

namespace g3d::hal::kinect {
namespace {

constexpr unsigned kPatience_ms = 1000;
constexpr std::uint8_t kToDevice = LIBUSB_REQUEST_TYPE_VENDOR, kFromDevice = kToDevice | LIBUSB_ENDPOINT_IN;

class LibusbControl final : public UsbControl {
 public:
  LibusbControl(libusb_context* context, libusb_device_handle* device) : context_(context), device_(device) {}
  ~LibusbControl() override {
    libusb_close(device_);
    libusb_exit(context_);
  }
  LibusbControl(const LibusbControl&) = delete;
  LibusbControl& operator=(const LibusbControl&) = delete;

  bool write(std::uint8_t request, std::uint16_t value) override {
    return libusb_control_transfer(device_, kToDevice, request, value, 0, nullptr, 0, kPatience_ms) == 0;
  }
  int read(std::uint8_t request, std::span<std::uint8_t> into) override {
    const int bytes = libusb_control_transfer(device_, kFromDevice, request, 0, 0, into.data(),
                                              static_cast<std::uint16_t>(into.size()), kPatience_ms);
    return bytes < 0 ? -1 : bytes;
  }

 private:
  libusb_context* context_;
  libusb_device_handle* device_;
};

}  // namespace

Result<std::unique_ptr<UsbControl>> open_usb_control(std::uint16_t vendor, std::uint16_t product) {
  libusb_context* context = nullptr;
  if (const int status = libusb_init(&context); status != 0) {
    return Error{Reason::unsupported, fmt::format("this machine has no USB: {}", libusb_error_name(status))};
  }
  libusb_device** devices = nullptr;
  const ssize_t count = libusb_get_device_list(context, &devices);
  int status = LIBUSB_ERROR_NO_DEVICE;
  libusb_device_handle* handle = nullptr;
  for (ssize_t i = 0; i < count && handle == nullptr; ++i) {
    libusb_device_descriptor about{};
    if (libusb_get_device_descriptor(devices[i], &about) != 0) continue;
    if (about.idVendor == vendor && about.idProduct == product) status = libusb_open(devices[i], &handle);
  }
  if (count >= 0) libusb_free_device_list(devices, 1);
  if (handle != nullptr) return std::unique_ptr<UsbControl>(std::make_unique<LibusbControl>(context, handle));
  libusb_exit(context);
  const Reason reason = status == LIBUSB_ERROR_NO_DEVICE ? Reason::not_found
                        : status == LIBUSB_ERROR_ACCESS  ? Reason::no_permission
                                                         : Reason::io_error;
  return Error{reason, fmt::format("USB device {:04x}:{:04x}: {}", vendor, product, libusb_error_name(status))};
}

}  // namespace g3d::hal::kinect
