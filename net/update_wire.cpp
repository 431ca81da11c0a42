// SPDX-License-Identifier: Apache-2.0
#include "net/update_wire.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

namespace g3d::net {
namespace {

constexpr std::array<std::uint8_t, 8> kGreetingMark{'G', '3', 'D', 'U', 'P', 'D', '1', 0};
constexpr std::array<std::uint8_t, 8> kProofMark{'G', '3', 'D', 'S', 'N', 'D', '1', 0};
constexpr std::string_view kSessionDomain = "g3dmap update session 1";
constexpr std::size_t kSignature_at = kProof_bytes - sizeof(Signature);

template <typename T>
void put_at(std::uint8_t* at, const T& value) {
  std::memcpy(at, &value, sizeof value);
}
template <typename T>
void take_at(const std::uint8_t* at, T& value) {
  std::memcpy(&value, at, sizeof value);
}

bool are_zero_bytes(const std::uint8_t* at, std::size_t count) {
  return std::all_of(at, at + count, [](std::uint8_t byte) { return byte == 0; });
}

mapper::Bytes what_is_signed(const GreetingBytes& greeting, const ProofBytes& proof) {
  mapper::Bytes bytes(kSessionDomain.begin(), kSessionDomain.end());
  mapper::put_bytes(bytes, greeting);
  mapper::put_bytes(bytes, std::span(proof).first(kSignature_at));
  return bytes;
}

}  // namespace

GreetingBytes encode_greeting(const UpdateGreeting& greeting) {
  GreetingBytes bytes{};
  put_at(&bytes[0], kGreetingMark);
  put_at(&bytes[8], greeting.nonce);
  put_at(&bytes[40], greeting.running_release);
  put_at(&bytes[48], greeting.newest_good_release);
  return bytes;
}

bool decode_greeting(const GreetingBytes& bytes, UpdateGreeting& greeting) {
  if (!std::equal(kGreetingMark.begin(), kGreetingMark.end(), bytes.begin()) || !are_zero_bytes(&bytes[56], 8))
    return false;
  take_at(&bytes[8], greeting.nonce);
  take_at(&bytes[40], greeting.running_release);
  take_at(&bytes[48], greeting.newest_good_release);
  return true;
}

ProofBytes encode_proof(const UpdateProof& proof, const GreetingBytes& greeting, const SigningKey& key) {
  ProofBytes bytes{};
  put_at(&bytes[0], kProofMark);
  bytes[8] = proof.force ? 1 : 0;
  put_at(&bytes[16], proof.manifest_bytes);
  put_at(&bytes[24], proof.manifest_digest);
  put_at(&bytes[kSignature_at], key.sign(what_is_signed(greeting, bytes)));
  return bytes;
}

ProofFault decode_proof(const ProofBytes& bytes, const GreetingBytes& greeting, const UpdateKey& key,
                        UpdateProof& proof) {
  Signature signature;
  take_at(&bytes[kSignature_at], signature);
  if (!key.has_signed(what_is_signed(greeting, bytes), signature)) return ProofFault::wrong_key;
  UpdateProof read;
  take_at(&bytes[16], read.manifest_bytes);
  take_at(&bytes[24], read.manifest_digest);
  read.force = bytes[8] == 1;
  if (!std::equal(kProofMark.begin(), kProofMark.end(), bytes.begin()) || bytes[8] > 1 ||
      !are_zero_bytes(&bytes[9], 7) || !are_zero_bytes(&bytes[20], 4) || read.manifest_bytes < kManifestHead_bytes ||
      read.manifest_bytes > kMostManifest_bytes) {
    return ProofFault::bad_field;
  }
  proof = read;
  return ProofFault::none;
}

const char* to_string(UpdateEnd end) {
  switch (end) {
    case UpdateEnd::installed:
      return "installed";
    case UpdateEnd::already_there:
      return "already there";
    case UpdateEnd::wrong_key:
      return "wrong key";
    case UpdateEnd::busy:
      return "busy";
    case UpdateEnd::not_newer:
      return "not newer";
    case UpdateEnd::failed_before:
      return "failed before";
    case UpdateEnd::not_now:
      return "not now";
    case UpdateEnd::too_large:
      return "too large";
    case UpdateEnd::malformed:
      return "malformed";
    case UpdateEnd::wrong_chunk:
      return "wrong chunk";
    case UpdateEnd::disk_full:
      return "disk full";
    case UpdateEnd::disk_error:
      return "disk error";
    case UpdateEnd::read_back_differs:
      return "read back differs";
    case UpdateEnd::too_slow:
      return "too slow";
    case UpdateEnd::stopping:
      return "stopping";
    case UpdateEnd::count_:
      break;
  }
  return "unknown";
}

WordBytes encode_word(const UpdateWord& word) {
  WordBytes bytes{};
  bytes[0] = static_cast<std::uint8_t>(word.kind);
  bytes[1] = static_cast<std::uint8_t>(word.end);
  put_at(&bytes[4], word.number);
  return bytes;
}

bool decode_word(const WordBytes& bytes, UpdateWord& word) {
  const bool is_known = bytes[0] >= static_cast<std::uint8_t>(UpdateWord::Kind::want) &&
                        bytes[0] <= static_cast<std::uint8_t>(UpdateWord::Kind::end) &&
                        bytes[1] < static_cast<std::uint8_t>(UpdateEnd::count_) && are_zero_bytes(&bytes[2], 2);
  if (!is_known) return false;
  word.kind = static_cast<UpdateWord::Kind>(bytes[0]);
  word.end = static_cast<UpdateEnd>(bytes[1]);
  take_at(&bytes[4], word.number);
  return true;
}

}  // namespace g3d::net
