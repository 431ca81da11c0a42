// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/device_check.hpp"

#include <fmt/format.h>

#include <cassert>

namespace g3d::hal::kobuki {
namespace {

using Version = std::array<std::uint8_t, 3>;
constexpr Version kGyroDriftFixed{1, 1, 4};
constexpr Version kGainsSettable{1, 2, 0};

}  // namespace

std::string version_text(const Version& version) { return fmt::format("{}.{}.{}", version[0], version[1], version[2]); }

std::string udid_text(const std::array<std::uint32_t, 3>& udid) {
  return fmt::format("{}-{}-{}", udid[0], udid[1], udid[2]);
}

Result<std::string> check_device(const DeviceInfo& info) {
  assert(info.has_firmware && "ask for the version first");
  const std::string has = version_text(info.firmware);
  if (info.firmware[0] != 1) {
    return Error{Reason::unsupported,
                 fmt::format("kobuki: firmware {} is not supported; install firmware 1.2.0 on the base", has)};
  }
  if (info.firmware < kGyroDriftFixed) {
    return fmt::format("kobuki: firmware {} has a drifting gyro; install 1.1.4 or later on the base", has);
  }
  if (info.firmware < kGainsSettable) {
    return fmt::format("kobuki: firmware {} does not let motor gains be set; install 1.2.0 on the base for that", has);
  }
  return std::string{};
}

}  // namespace g3d::hal::kobuki
