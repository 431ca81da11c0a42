// SPDX-License-Identifier: Apache-2.0
#include "net/signing_key.hpp"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::net;
using hal::Reason;
using test::TempFolder;

namespace {

std::vector<std::uint8_t> some_bytes(std::size_t count) {
  std::vector<std::uint8_t> bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::uint8_t>(i * 7);
  return bytes;
}

}  // namespace

TEST_CASE("what a key has signed is known to be its own, and nothing else is", "[update]") {
  const SigningKey key = SigningKey::random(), other = SigningKey::random();
  auto bytes = some_bytes(200);
  const Signature signature = key.sign(bytes);
  CHECK(key.update_key().has_signed(bytes, signature));
  CHECK_FALSE(other.update_key().has_signed(bytes, signature));
  CHECK_FALSE(UpdateKey{}.has_signed(bytes, signature));
  CHECK_FALSE(UpdateKey{}.has_signed(bytes, Signature{}));
  CHECK_FALSE(key.update_key().has_signed(std::span(bytes).first(199), signature));
  for (std::size_t bit = 0; bit < 8 * signature.size(); bit += 7) {
    Signature flipped = signature;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
    REQUIRE_FALSE(key.update_key().has_signed(bytes, flipped));
  }
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] ^= 1U;
    REQUIRE_FALSE(key.update_key().has_signed(bytes, signature));
    bytes[i] ^= 1U;
  }
}

TEST_CASE("Ed25519 as RFC 8032 has it", "[update]") {
  SecretKey seed;
  REQUIRE(SecretKey::from_hex("9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60", seed));
  const SigningKey key(std::move(seed));
  CHECK_THAT(format_update_key(key.update_key()),
             Catch::Contains("d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a"));
  const Signature signature = key.sign({});
  CHECK(signature[0] == 0xe5);
  CHECK(signature[63] == 0x0b);
}

TEST_CASE("both halves of a key go through their files, and only one of them is secret", "[update]") {
  const TempFolder folder;
  const std::string path = folder / "owner.key";
  const SigningKey key = SigningKey::random();
  REQUIRE(write_new_signing_key(path, key).ok());
  CHECK(folder.listing() == "owner.key\nowner.key.pub\n");
  struct stat status {};
  REQUIRE(::stat(path.c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == 0600);
  const auto secret = read_signing_key(path);
  REQUIRE(secret.ok());
  CHECK(secret.value().update_key() == key.update_key());
  const auto half = read_update_key(path + ".pub");
  REQUIRE(half.ok());
  CHECK(half.value() == key.update_key());
  const std::string hex = key.seed().to_hex();
  CHECK(test::read_plain(path).find(hex) != std::string::npos);
  CHECK(test::read_plain(path + ".pub").find(hex.substr(0, 16)) == std::string::npos);

  CHECK(write_new_signing_key(path, SigningKey::random()).error().reason == Reason::no_permission);
  CHECK(read_signing_key(path).value().update_key() == key.update_key());
  CHECK(read_signing_key(path + ".pub").error().reason == Reason::no_permission);  // others may read it
  REQUIRE(::chmod((path + ".pub").c_str(), 0600) == 0);
  const auto swapped = read_signing_key(path + ".pub");
  CHECK(swapped.error().reason == Reason::unsupported);
  CHECK_THAT(swapped.error().text, Catch::Contains("not the .pub one"));
  CHECK(read_update_key(path).error().reason == Reason::unsupported);
  REQUIRE(::chmod(path.c_str(), 0640) == 0);
  CHECK(read_signing_key(path).error().reason == Reason::no_permission);
  CHECK(read_update_key(folder / "none").error().reason == Reason::not_found);
}

TEST_CASE("key files that are none name what is wrong", "[update]") {
  const std::string digits(64, 'a');
  const std::vector<std::pair<std::string, Reason>> wrong{
      {"", Reason::malformed},
      {"g3dmap update key 1\n", Reason::malformed},
      {"g3dmap update key 2\nkey " + digits + "\n", Reason::unsupported},
      {"key " + digits + "\n", Reason::unsupported},
      {"g3dmap update key 1\nkey " + digits + "\nkey " + digits + "\n", Reason::malformed},
      {"g3dmap update key 1\nkey " + digits + "0\n", Reason::malformed},
      {"g3dmap update key 1\nkey " + digits.substr(1) + "\n", Reason::malformed},
      {"g3dmap update key 1\nkey " + std::string(64, '0') + "\n", Reason::malformed},
      {"g3dmap update key 1\nkey " + std::string(64, 'g') + "\n", Reason::malformed},
      {"g3dmap update key 1\nlock " + digits + "\n", Reason::malformed},
  };
  for (const auto& [text, reason] : wrong) {
    INFO(text);
    const auto read = parse_update_key(text, "f");
    REQUIRE_FALSE(read.ok());
    CHECK(read.error().reason == reason);
    CHECK_THAT(read.error().text, Catch::StartsWith("f:") && Catch::Contains(";"));
  }
  CHECK(parse_update_key("# a\n\ng3dmap update key 1\n# b\nkey " + digits, "f").ok());
}
