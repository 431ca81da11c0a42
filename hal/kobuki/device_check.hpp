// SPDX-License-Identifier: Apache-2.0
// Whether this program may drive the base that answered, and what to tell the person who plugged it in.
#pragma once

#include <string>

#include "hal/kobuki/feedback.hpp"
#include "hal/result.hpp"

namespace g3d::hal::kobuki {

/// Nothing to say: an empty text. A base that should be updated, but works: a warning. Firmware of another major
/// version than 1: an error (Reason::unsupported). Precondition: has_firmware.
[[nodiscard]] Result<std::string> check_device(const DeviceInfo& info);

/// "1.2.0"
[[nodiscard]] std::string version_text(const std::array<std::uint8_t, 3>& version);
/// "98238259-926504013-1360618305", as the base's own tools print it.
[[nodiscard]] std::string udid_text(const std::array<std::uint32_t, 3>& udid);

}  // namespace g3d::hal::kobuki
