// SPDX-License-Identifier: Apache-2.0
// Loads kernel modules in the order of a list that the image carries: dependencies first, as modprobe --show-depends
// names them. Blocks; one thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace g3d::hal::boot {

struct ModuleLine {
  std::string file;       ///< relative to the folder of the modules; ends with .ko
  std::string arguments;  ///< as for insmod
  bool operator==(const ModuleLine&) const = default;
};
/// A line per module, `FILE [ARGUMENTS]`; empty lines and those with '#' are skipped. At most 256, nothing with "..".
[[nodiscard]] std::vector<ModuleLine> parse_module_list(std::string_view text);

struct ModulesLoaded {
  int loaded = 0;
  std::vector<std::string> failures;  ///< "FILE: why"; one that is loaded already is none
};
[[nodiscard]] ModulesLoaded load_modules(const std::string& folder, const std::vector<ModuleLine>& modules);

}  // namespace g3d::hal::boot
