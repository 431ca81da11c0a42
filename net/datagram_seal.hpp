// SPDX-License-Identifier: Apache-2.0
// One datagram, encrypted and authenticated with the fleet's key (XChaCha20-Poly1305). On the wire, little-endian:
//
//   u8 kind | u8 low byte of the epoch | u64 session | u40 counter | ciphertext | 16 bytes of tag
//
// Everything before the ciphertext is authenticated with it. A nonce is a constant, session and counter: a session is
// drawn anew whenever a sender is made and a counter is used once, so no nonce comes twice under a key. What opens is
// from the fleet; whether it is from now, the session table says. One thread; nothing allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "net/fleet_key.hpp"

namespace g3d::net {

inline constexpr std::size_t kMostDatagram_bytes = 1200;
inline constexpr std::size_t kEnvelopeHeader_bytes = 1 + 1 + 8 + 5;
inline constexpr std::size_t kEnvelopeTag_bytes = 16;
inline constexpr std::size_t kEnvelope_bytes = kEnvelopeHeader_bytes + kEnvelopeTag_bytes;
inline constexpr std::size_t kMostPlaintext_bytes = kMostDatagram_bytes - kEnvelope_bytes;
inline constexpr std::uint64_t kMostCounter = (std::uint64_t{1} << 40) - 1;

using DatagramBuffer = std::span<std::uint8_t, kMostDatagram_bytes>;

/// Authenticated like the rest, so that nothing inside is taken for what it is not.
struct DatagramKind {
  bool handshake = false;    ///< a handshake message instead of what the fleet talks about
  bool holds_newer = false;  ///< sealed under the previous epoch, but the sender has the current key as well
};

enum class SealVerdict : std::uint8_t {
  sealed,
  too_long,   ///< more than kMostPlaintext_bytes
  exhausted,  ///< 2^40 datagrams were sent: only a new session may send more
};

/// Where a sender begins. Two senders must never share a session.
struct SenderStart {
  std::uint64_t session;
  std::uint64_t counter = 0;
};
[[nodiscard]] SenderStart fresh_sender_start();

class Sealer {
 public:
  explicit Sealer(SenderStart start = fresh_sender_start()) : session_(start.session), counter_(start.counter) {}
  Sealer(const Sealer&) = delete;  // a copy would use every nonce again
  Sealer& operator=(const Sealer&) = delete;

  struct Sealed {
    SealVerdict verdict;
    std::size_t size_bytes = 0;
  };
  /// `plaintext` and `out` must not overlap. `key` is that of `epoch`.
  [[nodiscard]] Sealed seal(DatagramKind kind, std::uint16_t epoch, const SecretKey& key,
                            std::span<const std::uint8_t> plaintext, DatagramBuffer out);
  [[nodiscard]] std::uint64_t session() const { return session_; }
  [[nodiscard]] std::uint64_t next_counter() const { return counter_; }

 private:
  const std::uint64_t session_;
  std::uint64_t counter_;
};

enum class OpenVerdict : std::uint8_t { opened, too_short, too_long, unknown_format, unknown_epoch, forged };

/// What stands before the ciphertext; to be believed after open() alone.
struct Envelope {
  OpenVerdict verdict = OpenVerdict::too_short;  ///< from look(): opened means that nothing speaks against trying
  DatagramKind kind;
  bool previous_epoch = false;
  std::uint64_t session = 0;
  std::uint64_t counter = 0;
};

class Opener {
 public:
  /// `keys` must outlive it, and may be changed between calls.
  explicit Opener(const FleetKey& keys) : keys_(keys) {}

  /// Costs nothing: no cryptography.
  [[nodiscard]] Envelope look(std::span<const std::uint8_t> datagram) const;

  struct Opened {
    Envelope envelope;
    std::span<const std::uint8_t> plaintext;  ///< in `out`; empty unless opened
  };
  /// `datagram` and `out` must not overlap. What is forged leaves nothing of itself in `out`.
  [[nodiscard]] Opened open(std::span<const std::uint8_t> datagram, DatagramBuffer out) const;

 private:
  const FleetKey& keys_;
};

}  // namespace g3d::net
