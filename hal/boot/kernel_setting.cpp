// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/kernel_setting.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace g3d::hal::boot {

bool set_kernel(const std::string& file, std::string_view value) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool is_taken = ::write(fd, value.data(), value.size()) == static_cast<ssize_t>(value.size());
  ::close(fd);
  return is_taken;
}

}  // namespace g3d::hal::boot
