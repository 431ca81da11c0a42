// SPDX-License-Identifier: Apache-2.0
#include "net/secret_key.hpp"

#include <sodium.h>

#include <array>
#include <cstring>
#include <new>
#include <utility>

namespace g3d::net {
namespace {

constexpr std::string_view kFingerprintDomain = "g3dmap fleet key";

}  // namespace

// Pages between guards, locked where RLIMIT_MEMLOCK allows it; sodium_free wipes them.
SecretKey::SecretKey() {
  if (sodium_init() < 0) throw std::bad_alloc();  // only without any source of randomness
  bytes_.reset(static_cast<std::uint8_t*>(sodium_malloc(kSize_bytes)));
  if (!bytes_) throw std::bad_alloc();
  std::memset(bytes_.get(), 0, kSize_bytes);
}

void SecretKey::Free::operator()(std::uint8_t* bytes) const { sodium_free(bytes); }

SecretKey SecretKey::random() {
  SecretKey key;
  randombytes_buf(key.bytes_.get(), kSize_bytes);
  return key;
}

bool SecretKey::from_hex(std::string_view hex, SecretKey& key) {
  if (hex.size() != kHex_chars) return false;
  SecretKey read;
  std::size_t read_bytes = 0;
  const char* end = nullptr;
  const int failed = sodium_hex2bin(read.bytes_.get(), kSize_bytes, hex.data(), hex.size(), nullptr, &read_bytes, &end);
  if (failed != 0 || read_bytes != kSize_bytes || end != hex.data() + hex.size()) return false;
  key = std::move(read);
  return true;
}

SecretKey SecretKey::copy() const {
  SecretKey key;
  std::memcpy(key.bytes_.get(), bytes_.get(), kSize_bytes);
  return key;
}

bool SecretKey::equals(const SecretKey& other) const {
  return sodium_memcmp(bytes_.get(), other.bytes_.get(), kSize_bytes) == 0;
}

std::string SecretKey::to_hex() const {
  std::string hex(kHex_chars + 1, '\0');
  sodium_bin2hex(hex.data(), hex.size(), bytes_.get(), kSize_bytes);
  hex.resize(kHex_chars);
  return hex;
}

std::string SecretKey::fingerprint() const {
  std::array<std::uint8_t, crypto_generichash_BYTES_MIN> digest;
  crypto_generichash(digest.data(), digest.size(), reinterpret_cast<const std::uint8_t*>(kFingerprintDomain.data()),
                     kFingerprintDomain.size(), bytes_.get(), kSize_bytes);
  constexpr std::size_t kShown_bytes = 8;
  std::array<char, 2 * kShown_bytes + 1> hex;
  sodium_bin2hex(hex.data(), hex.size(), digest.data(), kShown_bytes);
  return hex.data();
}

void wipe_text(std::string& text) {
  sodium_memzero(text.data(), text.size());
  text.clear();
}

std::uint64_t random_u64() {
  std::uint64_t number = 0;
  randombytes_buf(&number, sizeof(number));
  return number;
}

}  // namespace g3d::net
