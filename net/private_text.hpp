// SPDX-License-Identifier: Apache-2.0
// A small text file with a secret in it: read only if nobody but its owner can get at it, and wiped when it goes. One
// thread.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "hal/result.hpp"

namespace g3d::net {

struct PrivateText {
  static constexpr std::size_t kMost_bytes = 16 * 1024;

  PrivateText() = default;
  ~PrivateText();
  PrivateText(const PrivateText&) = delete;
  PrivateText& operator=(const PrivateText&) = delete;
  [[nodiscard]] std::string_view view() const { return {bytes.data(), size_bytes}; }

  std::array<char, kMost_bytes + 1> bytes;
  std::size_t size_bytes = 0;
};

/// `what` is in the file, such as "fleet key"; `if_seen` says what to do where others may have read it: both stand in
/// errors. Errors: no_permission if anybody but the owner may read or write the file, or it is another user's;
/// not_found, unsupported (no regular file), too_large, io_error.
[[nodiscard]] hal::Result<void> read_private_text(const std::string& path, std::string_view what,
                                                  std::string_view if_seen, PrivateText& text);

}  // namespace g3d::net
