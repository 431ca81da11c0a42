// SPDX-License-Identifier: Apache-2.0
// 32 secret bytes in memory of their own: never swapped out where the system allows that, no part of a core dump, wiped
// when they go. Made and moved by one thread, read by any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace g3d::net {

class SecretKey {
 public:
  static constexpr std::size_t kSize_bytes = 32;
  static constexpr std::size_t kHex_chars = 2 * kSize_bytes;

  /// From the kernel's randomness.
  [[nodiscard]] static SecretKey random();
  /// False, and `key` as it was, unless `hex` is exactly kHex_chars hexadecimal digits.
  [[nodiscard]] static bool from_hex(std::string_view hex, SecretKey& key);

  /// Zero bytes: no key yet.
  SecretKey();
  SecretKey(SecretKey&&) noexcept = default;
  SecretKey& operator=(SecretKey&&) noexcept = default;
  [[nodiscard]] SecretKey copy() const;

  [[nodiscard]] const std::uint8_t* data() const { return bytes_.get(); }
  /// Takes as long for any two keys.
  [[nodiscard]] bool equals(const SecretKey& other) const;
  /// The caller wipes it (wipe_text).
  [[nodiscard]] std::string to_hex() const;
  /// 16 hexadecimal digits by which people compare keys; says nothing about the key.
  [[nodiscard]] std::string fingerprint() const;

 private:
  struct Free {
    void operator()(std::uint8_t* bytes) const;
  };
  std::unique_ptr<std::uint8_t, Free> bytes_;
};

/// Zeroes what the text holds, in a way that no compiler leaves out, and empties it.
void wipe_text(std::string& text);

/// From the kernel's randomness.
[[nodiscard]] std::uint64_t random_u64();

}  // namespace g3d::net
