// SPDX-License-Identifier: Apache-2.0
// What a machine and the sender of an update say to each other over one TCP connection; little-endian, fixed sizes.
//
//   machine   greeting, 64 bytes: "G3DUPD1\0", 32 random bytes, u64 release that runs, u64 newest good release, 8 zeros
//   sender    proof, 120 bytes: "G3DSND1\0", u8 force, 7 zeros, u32 manifest's size, 4 zeros, 32 bytes its BLAKE2b-256,
//             64 bytes Ed25519 signature of the greeting and of the proof so far
//   sender    the manifest
//   machine   words, 8 bytes each: u8 kind, u8 end, 2 zeros, u32 number
//   sender    for each word `want`: u32 chunk, its bytes
//
// The signature covers the machine's random bytes: what was recorded is worth nothing, neither an old release nor the
// wish to go back. Nothing but sizes is looked at before it was checked. What the machine says is not proved: whoever
// answers at its address may claim that all went well, or pass on the greeting of another machine of the same owner,
// which then gets that update. Nothing is encrypted. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "net/signing_key.hpp"
#include "net/update_manifest.hpp"

namespace g3d::net {

inline constexpr std::uint16_t kUpdatePort = 7178;
inline constexpr std::size_t kGreeting_bytes = 64;
inline constexpr std::size_t kProof_bytes = 120;
inline constexpr std::size_t kWord_bytes = 8;
inline constexpr std::size_t kChunkHead_bytes = 4;
/// A sender may be asked for so many chunks before it has sent the first of them.
inline constexpr std::size_t kMostWanted = 8;

using GreetingBytes = std::array<std::uint8_t, kGreeting_bytes>;
using ProofBytes = std::array<std::uint8_t, kProof_bytes>;
using WordBytes = std::array<std::uint8_t, kWord_bytes>;

struct UpdateGreeting {
  std::array<std::uint8_t, 32> nonce{};
  std::uint64_t running_release = 0;
  std::uint64_t newest_good_release = 0;
  bool operator==(const UpdateGreeting&) const = default;
};
[[nodiscard]] GreetingBytes encode_greeting(const UpdateGreeting& greeting);
[[nodiscard]] bool decode_greeting(const GreetingBytes& bytes, UpdateGreeting& greeting);

struct UpdateProof {
  bool force = false;  ///< an older release, or one that failed here before, is meant
  std::uint32_t manifest_bytes = 0;
  hal::ImageDigest manifest_digest{};
  bool operator==(const UpdateProof&) const = default;
};
[[nodiscard]] ProofBytes encode_proof(const UpdateProof& proof, const GreetingBytes& greeting, const SigningKey& key);

enum class ProofFault : std::uint8_t {
  none,
  wrong_key,  ///< not signed by the holder of the key, or not for this greeting
  bad_field,  ///< signed, but not of this version
};
[[nodiscard]] ProofFault decode_proof(const ProofBytes& bytes, const GreetingBytes& greeting, const UpdateKey& key,
                                      UpdateProof& proof);

/// How an update has ended, on either side.
enum class UpdateEnd : std::uint8_t {
  installed,
  already_there,  ///< this very image runs, or waits for the next start
  wrong_key,
  busy,           ///< another sender is at it
  not_newer,      ///< its number is not above that of the newest good release
  failed_before,  ///< this very image did not come up here
  not_now,        ///< what runs has not proved itself yet, and the other slot is all there is to fall back to
  too_large,
  malformed,    ///< a message that is none
  wrong_chunk,  ///< not what the manifest promises
  disk_full,
  disk_error,
  read_back_differs,  ///< the disk returns something else
  too_slow,           ///< nothing came for too long
  stopping,           ///< the machine is about to restart or to be switched off
  count_,
};
[[nodiscard]] const char* to_string(UpdateEnd end);

struct UpdateWord {
  enum class Kind : std::uint8_t {
    want = 1,     ///< number: chunk
    working = 2,  ///< number: chunks that are in their place
    end = 3,      ///< how: `end`
  };
  Kind kind = Kind::working;
  UpdateEnd end = UpdateEnd::installed;
  std::uint32_t number = 0;
  bool operator==(const UpdateWord&) const = default;
};
[[nodiscard]] WordBytes encode_word(const UpdateWord& word);
[[nodiscard]] bool decode_word(const WordBytes& bytes, UpdateWord& word);

}  // namespace g3d::net
