// SPDX-License-Identifier: Apache-2.0
// The key by which a machine knows that an update is from its owner: Ed25519. Its secret half signs and stays with its
// holder; the public half goes on every machine. Both are small text files:
//
//   g3dmap signing key 1                    g3dmap update key 1
//   key 64 hexadecimal digits               key 64 hexadecimal digits
//
// Lines that begin with # say nothing. One thread; errors name file and remedy, never the secret.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/result.hpp"
#include "net/secret_key.hpp"

namespace g3d::net {

using Signature = std::array<std::uint8_t, 64>;

/// The public half.
struct UpdateKey {
  std::array<std::uint8_t, 32> bytes{};
  bool operator==(const UpdateKey&) const = default;

  /// Whether the holder of the secret half has signed exactly these bytes.
  [[nodiscard]] bool has_signed(std::span<const std::uint8_t> bytes, const Signature& signature) const;
  /// 16 hexadecimal digits by which people compare keys.
  [[nodiscard]] std::string fingerprint() const;
};

/// The secret half.
class SigningKey {
 public:
  [[nodiscard]] static SigningKey random() { return SigningKey(SecretKey::random()); }
  explicit SigningKey(SecretKey seed);

  [[nodiscard]] const UpdateKey& update_key() const { return update_key_; }
  [[nodiscard]] Signature sign(std::span<const std::uint8_t> bytes) const;
  [[nodiscard]] const SecretKey& seed() const { return seed_; }

 private:
  SecretKey seed_;
  UpdateKey update_key_;
};

/// Errors: malformed, unsupported (another version, or the other half).
[[nodiscard]] hal::Result<SigningKey> parse_signing_key(std::string_view text, const std::string& name);
[[nodiscard]] hal::Result<UpdateKey> parse_update_key(std::string_view text, const std::string& name);
[[nodiscard]] std::string format_update_key(const UpdateKey& key);

/// Errors: as above, and those of read_private_text.
[[nodiscard]] hal::Result<SigningKey> read_signing_key(const std::string& path);
[[nodiscard]] hal::Result<UpdateKey> read_update_key(const std::string& path);
/// `path`, mode 0600, and `path`.pub, which everybody may read. Refuses to replace either (no_permission).
[[nodiscard]] hal::Result<void> write_new_signing_key(const std::string& path, const SigningKey& key);

}  // namespace g3d::net
