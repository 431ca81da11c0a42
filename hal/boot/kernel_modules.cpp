// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/kernel_modules.hpp"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>

namespace g3d::hal::boot {
namespace {
constexpr std::size_t kMostModules = 256;
}

std::vector<ModuleLine> parse_module_list(std::string_view text) {
  std::vector<ModuleLine> modules;
  while (!text.empty() && modules.size() < kMostModules) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    while (!line.empty() && line.back() == ' ') line.remove_suffix(1);
    if (line.empty() || line.front() == '#') continue;
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string_view file = line.substr(0, space);
    if (!file.ends_with(".ko") || file.find("..") != std::string_view::npos) continue;
    modules.push_back({std::string(file), std::string(line.substr(std::min(space + 1, line.size())))});
  }
  return modules;
}

ModulesLoaded load_modules(const std::string& folder, const std::vector<ModuleLine>& modules) {
  ModulesLoaded result;
  for (const ModuleLine& module : modules) {
    const int fd = ::open((folder + "/" + module.file).c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_loaded = fd >= 0 && ::syscall(SYS_finit_module, fd, module.arguments.c_str(), 0) == 0;
    const int problem = errno;
    if (fd >= 0) ::close(fd);
    if (is_loaded) {
      ++result.loaded;
    } else if (problem != EEXIST) {
      const char* const why = ::strerrordesc_np(problem);
      result.failures.push_back(module.file + ": " + (why != nullptr ? why : "unknown error"));
    }
  }
  return result;
}

}  // namespace g3d::hal::boot
