// SPDX-License-Identifier: Apache-2.0
#include "net/update_offer.hpp"

namespace g3d::net {

UpdateOffer::UpdateOffer(const UpdateManifest& manifest, const SigningKey& key, bool force)
    : manifest_(manifest),
      key_(key),
      manifest_bytes_(encode_manifest(manifest)),
      force_(force),
      was_sent_(manifest.chunks.size()) {}

bool UpdateOffer::take_greeting(const GreetingBytes& bytes) {
  greeting_bytes_ = bytes;
  return decode_greeting(bytes, greeting_);
}

mapper::Bytes UpdateOffer::opening() const {
  UpdateProof proof;
  proof.force = force_;
  proof.manifest_bytes = static_cast<std::uint32_t>(manifest_bytes_.size());
  proof.manifest_digest = digest_of(manifest_bytes_);
  const ProofBytes signed_proof = encode_proof(proof, greeting_bytes_, key_);
  mapper::Bytes bytes(signed_proof.begin(), signed_proof.end());
  mapper::put_bytes(bytes, manifest_bytes_);
  return bytes;
}

UpdateOffer::Next UpdateOffer::take_word(const WordBytes& bytes) {
  UpdateWord word;
  if (!decode_word(bytes, word)) return Next::nonsense;
  if (word.kind == UpdateWord::Kind::end) {
    end_ = word.end;
    return Next::ended;
  }
  if (word.kind == UpdateWord::Kind::working) {
    if (word.number > manifest_.chunks.size()) return Next::nonsense;
    in_place_ = word.number;
    return Next::go_on;
  }
  if (word.number >= manifest_.chunks.size() || was_sent_[word.number]) return Next::nonsense;
  was_sent_[word.number] = true;
  chunk_ = word.number;
  return Next::send_chunk;
}

}  // namespace g3d::net
