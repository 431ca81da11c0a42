// SPDX-License-Identifier: Apache-2.0
#include "net/update_offer.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::net;
using Next = UpdateOffer::Next;

namespace {

UpdateManifest three_chunks() {
  UpdateManifest manifest;
  manifest.image = {7, 2 * kChunk_bytes + 5, {}};
  manifest.chunks.resize(3);
  return manifest;
}

WordBytes word(UpdateWord::Kind kind, std::uint32_t number, UpdateEnd end = UpdateEnd::installed) {
  return encode_word({kind, end, number});
}

}  // namespace

TEST_CASE("an offer opens with a proof for the greeting that it got", "[update]") {
  const UpdateManifest manifest = three_chunks();
  const SigningKey key = SigningKey::random();
  UpdateOffer offer(manifest, key, true);
  UpdateGreeting greeting;
  greeting.nonce.fill(8);
  CHECK_FALSE(offer.take_greeting(GreetingBytes{}));
  REQUIRE(offer.take_greeting(encode_greeting(greeting)));
  const auto opening = offer.opening();
  REQUIRE(opening.size() == kProof_bytes + kManifestHead_bytes + 3 * 32);
  ProofBytes bytes;
  std::copy_n(opening.begin(), bytes.size(), bytes.begin());
  UpdateProof proof;
  REQUIRE(decode_proof(bytes, encode_greeting(greeting), key.update_key(), proof) == ProofFault::none);
  CHECK(proof.force);
  CHECK(proof.manifest_digest == digest_of(std::span(opening).subspan(kProof_bytes)));
}

TEST_CASE("a machine gets each chunk once, and what makes no sense ends it", "[update]") {
  const UpdateManifest manifest = three_chunks();
  const SigningKey key = SigningKey::random();
  UpdateOffer offer(manifest, key, false);
  using Kind = UpdateWord::Kind;
  CHECK(offer.take_word(word(Kind::want, 2)) == Next::send_chunk);
  CHECK(offer.chunk() == 2);
  CHECK(offer.take_word(word(Kind::want, 2)) == Next::nonsense);
  CHECK(offer.take_word(word(Kind::want, 3)) == Next::nonsense);
  CHECK(offer.take_word(word(Kind::working, 4)) == Next::nonsense);
  CHECK(offer.take_word(word(Kind::working, 3)) == Next::go_on);
  CHECK(offer.in_place() == 3);
  CHECK(offer.take_word(WordBytes{9}) == Next::nonsense);
  CHECK(offer.take_word(word(Kind::end, 0, UpdateEnd::busy)) == Next::ended);
  CHECK(offer.end() == UpdateEnd::busy);
}
