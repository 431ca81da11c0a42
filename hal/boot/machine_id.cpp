// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/machine_id.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "hal/image/atomic_file.hpp"
#include "hal/image/file_bytes.hpp"

namespace g3d::hal::boot {
namespace {

constexpr std::size_t kIdDigits = 32;

bool is_machine_id(std::string_view text) {
  return text.size() == kIdDigits + 1 && text.back() == '\n' &&
         text.find_first_not_of("0123456789abcdef") == kIdDigits && text.find_first_not_of('0') < kIdDigits;
}

Result<void> make_machine_id(const std::string& path) {
  std::array<std::uint8_t, kIdDigits / 2> random{};
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) {
    return system_error("getrandom", "cannot draw", errno);
  }
  std::string text;
  for (const std::uint8_t byte : random) text += fmt::format("{:02x}", byte);
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto written = file.value().write(std::string_view(text + '\n')); !written) return written;
  return file.value().commit();
}

}  // namespace

Result<void> keep_machine_id(const std::string& kept, const std::string& shown) {
  const auto there = read_text_file(kept, 2 * kIdDigits);
  if (!there || !is_machine_id(there.value())) {
    if (auto made = make_machine_id(kept); !made) return made;
  }
  std::error_code code;
  std::filesystem::create_directories(std::filesystem::path(shown).parent_path(), code);
  if (!code) std::filesystem::remove(shown, code);
  if (!code) std::filesystem::create_symlink(kept, shown, code);
  if (code) return system_error(shown, "cannot link", code.value());
  return {};
}

}  // namespace g3d::hal::boot
