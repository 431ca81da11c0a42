// SPDX-License-Identifier: Apache-2.0
// init.toml lies on a partition that a power cut may have torn.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "hal/boot/init_config.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto config = g3d::hal::boot::parse_init_config({reinterpret_cast<const char*>(data), size}, "init.toml");
  if (config && (config.value().name.empty() || config.value().arguments.empty())) std::abort();
  return 0;
}
