// SPDX-License-Identifier: Apache-2.0
// The sender's side of one connection, apart from sockets: what the proof is, and what a word of the machine asks for.
// Whoever answers there has proved nothing, so it gets each chunk at most once and is refused whatever makes no sense.
// One thread.
#pragma once

#include <cstdint>
#include <vector>

#include "net/update_wire.hpp"

namespace g3d::net {

class UpdateOffer {
 public:
  UpdateOffer(const UpdateManifest& manifest, const SigningKey& key, bool force);

  /// False if this is no greeting of a machine that takes updates.
  [[nodiscard]] bool take_greeting(const GreetingBytes& bytes);
  [[nodiscard]] const UpdateGreeting& greeting() const { return greeting_; }
  /// The proof and the manifest, for that greeting.
  [[nodiscard]] mapper::Bytes opening() const;

  enum class Next : std::uint8_t { send_chunk, go_on, ended, nonsense };
  [[nodiscard]] Next take_word(const WordBytes& bytes);
  [[nodiscard]] std::uint32_t chunk() const { return chunk_; }        ///< after send_chunk
  [[nodiscard]] std::uint32_t in_place() const { return in_place_; }  ///< what the machine says that it has
  [[nodiscard]] UpdateEnd end() const { return end_; }                ///< after ended

 private:
  const UpdateManifest& manifest_;
  const SigningKey& key_;
  const mapper::Bytes manifest_bytes_;
  const bool force_;
  GreetingBytes greeting_bytes_{};
  UpdateGreeting greeting_;
  std::vector<bool> was_sent_;
  std::uint32_t chunk_ = 0;
  std::uint32_t in_place_ = 0;
  UpdateEnd end_ = UpdateEnd::malformed;
};

}  // namespace g3d::net
