// SPDX-License-Identifier: Apache-2.0
#include "net/secret_key.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace g3d::net;

TEST_CASE("two keys are two keys, a copy is the same") {
  const SecretKey a = SecretKey::random(), b = SecretKey::random();
  CHECK_FALSE(a.equals(b));
  CHECK(a.equals(a.copy()));
  CHECK_FALSE(a.equals(SecretKey()));
  CHECK(a.fingerprint() != b.fingerprint());
  CHECK(a.fingerprint() == a.copy().fingerprint());
  CHECK(a.fingerprint().size() == 16);
}

TEST_CASE("a key goes through text and back") {
  const SecretKey key = SecretKey::random();
  SecretKey read;
  REQUIRE(SecretKey::from_hex(key.to_hex(), read));
  CHECK(read.equals(key));
  CHECK(key.to_hex().find(key.fingerprint()) == std::string::npos);
}

TEST_CASE("what is not 64 hexadecimal digits is no key and changes none") {
  SecretKey key = SecretKey::random();
  const SecretKey before = key.copy();
  const std::string good(64, 'a');
  for (const std::string& bad : {std::string(), good.substr(1), good + "a", good.substr(1) + "g", good.substr(1) + " ",
                                 " " + good.substr(1), good.substr(2) + "\0a"}) {
    CHECK_FALSE(SecretKey::from_hex(bad, key));
    CHECK(key.equals(before));
  }
}

TEST_CASE("text that is wiped is gone") {
  std::string text(100, 'x');
  const char* const bytes = text.data();
  wipe_text(text);
  CHECK(text.empty());
  CHECK(bytes == text.data());
}

TEST_CASE("random numbers differ") { CHECK(random_u64() != random_u64()); }

}  // namespace
