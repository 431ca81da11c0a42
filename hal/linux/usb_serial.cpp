// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/usb_serial.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <limits.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <vector>

namespace g3d::hal {
namespace {

constexpr std::size_t kMaxPorts = 64;
constexpr int kMaxParents = 5;  // port, interface, device; hubs have strings of their own, so not far beyond

/// First line of a sysfs file, at most 255 bytes, printable ones only: it comes from whatever was plugged in.
std::optional<std::string> read_line(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return std::nullopt;
  std::array<char, 255> buffer;
  const ssize_t count = ::read(fd, buffer.data(), buffer.size());
  ::close(fd);
  if (count < 0) return std::nullopt;
  std::string line;
  for (ssize_t i = 0; i < count; ++i) {
    const char c = buffer[static_cast<std::size_t>(i)];
    if (c == '\n') break;
    line += c >= ' ' && c <= '~' ? c : '?';
  }
  return line;
}

std::vector<std::string> entries(const std::string& folder) {
  std::vector<std::string> names;
  DIR* const dir = ::opendir(folder.c_str());
  if (dir == nullptr) return names;
  while (const dirent* entry = ::readdir(dir)) {
    if (entry->d_name[0] != '.' && names.size() < kMaxPorts) names.emplace_back(entry->d_name);
  }
  ::closedir(dir);
  std::sort(names.begin(), names.end());
  return names;
}

/// The port's folder with all links resolved, then upwards to the first one with the strings of a USB device.
std::optional<UsbSerialDevice> describe(const std::string& link) {
  char* const resolved = ::realpath(link.c_str(), nullptr);
  if (resolved == nullptr) return std::nullopt;
  std::string folder = resolved;
  ::free(resolved);
  for (int i = 0; i < kMaxParents; ++i) {
    const auto vendor = read_line(folder + "/idVendor");
    if (vendor) {
      UsbSerialDevice device;
      device.product = read_line(folder + "/product").value_or("");
      device.serial = read_line(folder + "/serial").value_or("");
      return device;
    }
    const std::size_t slash = folder.rfind('/');
    if (slash == std::string::npos || slash == 0) break;
    folder.resize(slash);
  }
  return std::nullopt;
}

bool fits(const UsbSerialDevice& device, const UsbSerialMatch& match) {
  if (!match.product.empty() && device.product == match.product) return true;
  return !match.serial_prefix.empty() && device.serial.compare(0, match.serial_prefix.size(), match.serial_prefix) == 0;
}

std::string list(const std::vector<UsbSerialDevice>& devices) {
  std::string text;
  for (const UsbSerialDevice& d : devices) {
    text += fmt::format("{}{} (product \"{}\", serial \"{}\")", text.empty() ? "" : ", ", d.path, d.product, d.serial);
  }
  return text.empty() ? "none" : text;
}

}  // namespace

Result<UsbSerialDevice> find_usb_serial(const UsbSerialMatch& match, const std::string& sys_root,
                                        const std::string& dev_root) {
  const std::string folder = sys_root + "/bus/usb-serial/devices";
  std::vector<UsbSerialDevice> seen, fitting;
  for (const std::string& name : entries(folder)) {
    const std::string entry = fmt::format("{}/{}", folder, name);
    auto device = describe(entry);
    if (!device) continue;
    device->path = fmt::format("{}/{}", dev_root, name);
    if (const auto latency = read_line(entry + "/latency_timer")) {
      int value_ms = -1;
      const auto [end, error] = std::from_chars(latency->data(), latency->data() + latency->size(), value_ms);
      if (error == std::errc{} && end == latency->data() + latency->size()) device->latency_timer_ms = value_ms;
    }
    seen.push_back(*device);
    if (fits(*device, match)) fitting.push_back(*device);
  }
  if (fitting.size() == 1) return fitting.front();
  const std::string wanted = fmt::format("product \"{}\" or serial \"{}...\"", match.product, match.serial_prefix);
  if (fitting.empty()) {
    return Error{Reason::not_found, fmt::format("{}: no USB serial port with {}; there are: {}; plug the base in and "
                                                "switch it on, or name its port in the board file",
                                                folder, wanted, list(seen))};
  }
  return Error{Reason::bad_usage,
               fmt::format("{}: several ports fit {}: {}; give the whole serial string of the right one", folder,
                           wanted, list(fitting))};
}

}  // namespace g3d::hal
