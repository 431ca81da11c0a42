// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/log_lines.hpp"

namespace g3d::hal {

std::optional<std::string_view> LogLines::next() {
  for (;;) {
    const std::size_t end = rest_.find('\n');
    if (end == rest_.npos) return std::nullopt;
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    ++number_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty() && line.front() != '#') return line;
  }
}

}  // namespace g3d::hal
