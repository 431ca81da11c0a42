// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/large_pages.hpp"

#include "hal/boot/kernel_setting.hpp"
#include "hal/image/file_bytes.hpp"

namespace g3d::hal::boot {

bool allow_large_pages(const std::string& switch_file) {
  constexpr std::size_t kMostText_bytes = 4096;
  const auto text = read_text_file(switch_file, kMostText_bytes);
  if (!text) return false;
  return text.value().find("[never]") == std::string::npos || set_kernel(switch_file, "madvise");
}

}  // namespace g3d::hal::boot
