// SPDX-License-Identifier: Apache-2.0
// The machine's side of one update, apart from sockets: which bytes it waits for, what it does with them, what it says.
// Nobody is believed before the proof: until then it holds some hundred bytes and looks at none of them. Then the
// manifest (at most half a MiB) and one chunk at a time. What the slot holds already is compared with the manifest and
// not asked for again, so a cut update goes on where it was. All is read back and digested before the book is changed.
// One thread; the disk is touched by step() and took() alone, a chunk at a time.
#pragma once

#include <sodium.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "net/token_bucket.hpp"
#include "net/update_target.hpp"
#include "net/update_wire.hpp"

namespace g3d::net {

class UpdateIntake {
 public:
  enum class Phase : std::uint8_t { proof, manifest, comparing, receiving, reading_back, over };

  /// `nonce`: random, never used before. `rate_Bps`: how fast chunks are asked for, so that the robot's disk and radio
  /// have time for other things.
  UpdateIntake(const UpdateKey& key, UpdateTarget& target, const std::array<std::uint8_t, 32>& nonce, double rate_Bps);

  /// Where the next bytes of the connection belong; empty if none are wanted now.
  [[nodiscard]] std::span<std::uint8_t> wants();
  /// So many of them have come.
  void took(std::size_t count);
  /// One piece of work, if there is any. False: nothing to do before bytes come or `wait_until_ns`.
  bool step(hal::TimeNs now_ns);
  [[nodiscard]] hal::TimeNs wait_until_ns() const { return wait_until_ns_; }
  /// What is to be sent, in order; said() takes away what was.
  [[nodiscard]] std::span<const std::uint8_t> says() const { return std::span(out_).subspan(said_bytes_); }
  void said(std::size_t count);

  [[nodiscard]] Phase phase() const { return phase_; }
  /// It was proved that the sender holds the key.
  [[nodiscard]] bool is_proved() const { return is_proved_; }
  /// Bytes of the sender are due.
  [[nodiscard]] bool waits_for_sender() const;
  [[nodiscard]] std::optional<UpdateEnd> end() const { return end_; }
  /// Ends it from outside, such as with busy, too_slow or stopping.
  void finish(UpdateEnd end);
  [[nodiscard]] const hal::SlotImageId& image() const { return manifest_.image; }
  [[nodiscard]] std::uint32_t chunks_in_place() const { return in_place_; }
  [[nodiscard]] std::uint32_t chunks_received() const { return received_; }

 private:
  void take_proof();
  void take_manifest();
  void take_chunk();
  void compare_one();
  void read_back_one();
  void say(const UpdateWord& word);
  void ask(hal::TimeNs now_ns);
  void end_if(std::optional<UpdateEnd> end);

  const UpdateKey key_;
  UpdateTarget& target_;
  const GreetingBytes greeting_;
  const TokenRate rate_;
  TokenBucket bucket_;
  Phase phase_ = Phase::proof;
  bool is_proved_ = false;
  UpdateProof proof_;
  UpdateManifest manifest_;
  std::vector<std::uint8_t> in_;  ///< the message that is coming
  std::size_t had_bytes_ = 0;
  std::vector<std::uint8_t> out_;
  std::size_t said_bytes_ = 0;
  std::vector<std::uint32_t> missing_;  ///< chunks, ascending
  std::size_t asked_ = 0;               ///< of missing_
  std::size_t answered_ = 0;            ///< of missing_
  std::uint32_t at_chunk_ = 0;          ///< compared or read back next
  std::uint32_t in_place_ = 0;
  std::uint32_t received_ = 0;
  std::uint32_t unsynced_ = 0;
  crypto_generichash_state whole_{};  ///< of the image as it is read back
  hal::TimeNs wait_until_ns_ = 0;
  std::optional<UpdateEnd> end_;
};

}  // namespace g3d::net
