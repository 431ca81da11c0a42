// SPDX-License-Identifier: Apache-2.0
#include "net/signing_key.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "hal/image/atomic_file.hpp"
#include "net/private_text.hpp"

namespace g3d::net {
namespace {

using hal::Error;
using hal::Reason;

constexpr std::string_view kSigningMark = "g3dmap signing key 1";
constexpr std::string_view kUpdateMark = "g3dmap update key 1";
constexpr std::size_t kMostUpdateKey_bytes = 4096;

/// The digits of the one key line, or an Error.
hal::Result<std::string_view> key_digits(std::string_view text, std::string_view mark, const std::string& name,
                                         std::string_view remedy) {
  bool has_mark = false;
  std::string_view digits;
  for (std::size_t line_number = 1; !text.empty(); ++line_number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line.front() == '#') continue;
    if (!has_mark) {
      if (line != mark) {
        return Error{Reason::unsupported,
                     fmt::format("{}:{}: does not begin with '{}'; {}", name, line_number, mark, remedy)};
      }
      has_mark = true;
    } else if (line.starts_with("key ") && digits.empty()) {
      digits = line.substr(4);
    } else {
      return Error{Reason::malformed, fmt::format("{}:{}: is not its one key; {}", name, line_number, remedy)};
    }
  }
  if (!digits.empty()) return digits;
  return Error{Reason::malformed, fmt::format("{}: holds no key; {}", name, remedy)};
}

hal::Result<void> must_not_exist(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return {};
  return Error{Reason::no_permission,
               fmt::format("{}: is there already, and machines may trust it; choose another name", path)};
}

}  // namespace

bool UpdateKey::has_signed(std::span<const std::uint8_t> signed_bytes, const Signature& signature) const {
  return sodium_init() >= 0 &&
         crypto_sign_verify_detached(signature.data(), signed_bytes.data(), signed_bytes.size(), bytes.data()) == 0;
}

std::string UpdateKey::fingerprint() const {
  std::array<std::uint8_t, crypto_generichash_BYTES_MIN> digest;
  crypto_generichash(digest.data(), digest.size(), bytes.data(), bytes.size(), nullptr, 0);
  std::string text;
  for (std::size_t i = 0; i < 8; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

SigningKey::SigningKey(SecretKey seed) : seed_(std::move(seed)) {
  std::array<std::uint8_t, crypto_sign_SECRETKEYBYTES> secret;
  crypto_sign_seed_keypair(update_key_.bytes.data(), secret.data(), seed_.data());
  sodium_memzero(secret.data(), secret.size());
}

Signature SigningKey::sign(std::span<const std::uint8_t> bytes) const {
  std::array<std::uint8_t, crypto_sign_SECRETKEYBYTES> secret;
  std::array<std::uint8_t, crypto_sign_PUBLICKEYBYTES> half;
  crypto_sign_seed_keypair(half.data(), secret.data(), seed_.data());
  Signature signature;
  crypto_sign_detached(signature.data(), nullptr, bytes.data(), bytes.size(), secret.data());
  sodium_memzero(secret.data(), secret.size());
  return signature;
}

hal::Result<SigningKey> parse_signing_key(std::string_view text, const std::string& name) {
  constexpr std::string_view kRemedy = "give the file that g3dmap update --new-key has made, not the .pub one";
  const auto digits = key_digits(text, kSigningMark, name, kRemedy);
  if (!digits) return digits.error();
  SecretKey seed;
  if (!SecretKey::from_hex(digits.value(), seed) || seed.equals(SecretKey())) {
    return Error{Reason::malformed, fmt::format("{}: its key is not 64 hexadecimal digits; {}", name, kRemedy)};
  }
  return SigningKey(std::move(seed));
}

hal::Result<UpdateKey> parse_update_key(std::string_view text, const std::string& name) {
  constexpr std::string_view kRemedy = "give the .pub file that g3dmap update --new-key has made";
  const auto digits = key_digits(text, kUpdateMark, name, kRemedy);
  if (!digits) return digits.error();
  UpdateKey key;
  std::size_t read_bytes = 0;
  const char* end = nullptr;
  const std::string_view hex = digits.value();
  const bool is_read =
      sodium_hex2bin(key.bytes.data(), key.bytes.size(), hex.data(), hex.size(), nullptr, &read_bytes, &end) == 0;
  if (!is_read || read_bytes != key.bytes.size() || end != hex.data() + hex.size() || key == UpdateKey{}) {
    return Error{Reason::malformed, fmt::format("{}: its key is not 64 hexadecimal digits; {}", name, kRemedy)};
  }
  return key;
}

std::string format_update_key(const UpdateKey& key) {
  std::string text = fmt::format(
      "# A machine with this file takes updates from the holder of the key that it belongs to.\n{}\nkey ", kUpdateMark);
  for (const std::uint8_t byte : key.bytes) text += fmt::format("{:02x}", byte);
  return text + "\n";
}

hal::Result<SigningKey> read_signing_key(const std::string& path) {
  PrivateText text;
  const auto read = read_private_text(path, "signing key", "make a new one, and flash it", text);
  if (!read) return read.error();
  return parse_signing_key(text.view(), path);
}

hal::Result<UpdateKey> read_update_key(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return hal::system_error(path, "cannot open", errno);
  std::array<char, kMostUpdateKey_bytes> bytes;
  const ssize_t n = ::read(fd, bytes.data(), bytes.size());
  const int failed = errno;
  ::close(fd);
  if (n < 0) return hal::system_error(path, "cannot read", failed);
  return parse_update_key({bytes.data(), static_cast<std::size_t>(n)}, path);
}

hal::Result<void> write_new_signing_key(const std::string& path, const SigningKey& key) {
  const std::string pub = path + ".pub";
  for (const std::string& file : {path, pub}) {
    if (auto is_free = must_not_exist(file); !is_free) return is_free;
  }
  auto secret_file = hal::AtomicFile::create_private(path);
  if (!secret_file) return secret_file.error();
  std::string hex = key.seed().to_hex();
  std::string text;
  text.reserve(256);  // so that no smaller copy of the key is left behind
  text.append("# Whoever can read this file can put any system on the machines that trust it.\n")
      .append(kSigningMark)
      .append("\nkey ")
      .append(hex)
      .append("\n");
  hal::Result<void> written = secret_file.value().write(text);
  wipe_text(hex);
  wipe_text(text);
  if (written) written = secret_file.value().commit();
  if (!written) return written;
  auto pub_file = hal::AtomicFile::create(pub);
  if (!pub_file) return pub_file.error();
  written = pub_file.value().write(format_update_key(key.update_key()));
  return written ? pub_file.value().commit() : written;
}

}  // namespace g3d::net
