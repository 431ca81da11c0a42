// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/large_pages.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <string_view>

#include "hal/image/file_bytes.hpp"

namespace g3d::hal::boot {

bool allow_large_pages(const std::string& switch_file) {
  constexpr std::size_t kMostText_bytes = 4096;
  constexpr std::string_view kOnRequest = "madvise";
  const auto text = read_text_file(switch_file, kMostText_bytes);
  if (!text) return false;
  if (text.value().find("[never]") == std::string::npos) return true;
  const int fd = ::open(switch_file.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool is_written = ::write(fd, kOnRequest.data(), kOnRequest.size()) == static_cast<ssize_t>(kOnRequest.size());
  ::close(fd);
  return is_written;
}

}  // namespace g3d::hal::boot
