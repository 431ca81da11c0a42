// SPDX-License-Identifier: Apache-2.0
#include "net/update_wire.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

using namespace g3d;
using namespace g3d::net;

namespace {

UpdateGreeting greeting_with(std::uint8_t fill) {
  UpdateGreeting greeting;
  greeting.nonce.fill(fill);
  greeting.running_release = 4;
  greeting.newest_good_release = 5;
  return greeting;
}

UpdateProof small_proof() {
  UpdateProof proof;
  proof.manifest_bytes = 88;
  proof.manifest_digest.fill(9);
  return proof;
}

}  // namespace

TEST_CASE("what update sides say goes through the wire", "[update]") {
  UpdateGreeting greeting;
  REQUIRE(decode_greeting(encode_greeting(greeting_with(3)), greeting));
  CHECK(greeting == greeting_with(3));
  for (int kind = 1; kind <= 3; ++kind) {
    for (int end = 0; end < static_cast<int>(UpdateEnd::count_); ++end) {
      const UpdateWord said{static_cast<UpdateWord::Kind>(kind), static_cast<UpdateEnd>(end), 0xFFFFFFFF};
      UpdateWord word;
      REQUIRE(decode_word(encode_word(said), word));
      CHECK(word == said);
    }
  }
  UpdateWord word;
  for (const WordBytes& wrong : {WordBytes{0}, WordBytes{4}, WordBytes{1, static_cast<std::uint8_t>(UpdateEnd::count_)},
                                 WordBytes{1, 0, 1}, WordBytes{1, 0, 0, 1}}) {
    CHECK_FALSE(decode_word(wrong, word));
  }
  auto wrong = encode_greeting(greeting_with(3));
  wrong[63] = 1;
  CHECK_FALSE(decode_greeting(wrong, greeting));
  wrong = encode_greeting(greeting_with(3));
  wrong[6] = '2';
  CHECK_FALSE(decode_greeting(wrong, greeting));
  std::set<std::string> names;
  for (int end = 0; end <= static_cast<int>(UpdateEnd::count_); ++end)
    names.insert(to_string(static_cast<UpdateEnd>(end)));
  CHECK(names.size() == static_cast<std::size_t>(UpdateEnd::count_) + 1);
}

TEST_CASE("a proof is worth something for one greeting, one key, and as it is", "[update]") {
  const SigningKey key = SigningKey::random(), other = SigningKey::random();
  const GreetingBytes greeting = encode_greeting(greeting_with(1));
  UpdateProof proof = small_proof();
  proof.force = true;
  const ProofBytes bytes = encode_proof(proof, greeting, key);
  UpdateProof read;
  REQUIRE(decode_proof(bytes, greeting, key.update_key(), read) == ProofFault::none);
  CHECK(read == proof);

  read = {};
  CHECK(decode_proof(bytes, greeting, other.update_key(), read) == ProofFault::wrong_key);
  CHECK(decode_proof(bytes, encode_greeting(greeting_with(2)), key.update_key(), read) == ProofFault::wrong_key);
  for (std::size_t bit = 0; bit < 8 * kProof_bytes; ++bit) {
    ProofBytes flipped = bytes;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
    REQUIRE(decode_proof(flipped, greeting, key.update_key(), read) == ProofFault::wrong_key);
  }
  CHECK(read == UpdateProof{});
}

TEST_CASE("a proof whose signer speaks another version is refused as such", "[update]") {
  const SigningKey key = SigningKey::random();
  const GreetingBytes greeting = encode_greeting(greeting_with(1));
  UpdateProof read;
  for (const std::uint32_t size : {0U, 55U, static_cast<std::uint32_t>(kMostManifest_bytes) + 1, 0xFFFFFFFFU}) {
    UpdateProof proof = small_proof();
    proof.manifest_bytes = size;
    CHECK(decode_proof(encode_proof(proof, greeting, key), greeting, key.update_key(), read) == ProofFault::bad_field);
  }
}
