// SPDX-License-Identifier: Apache-2.0
#include "net/datagram_seal.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <tuple>

namespace g3d::net {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian; all our targets are, too");
static_assert(SecretKey::kSize_bytes == crypto_aead_xchacha20poly1305_ietf_KEYBYTES);
static_assert(kEnvelopeTag_bytes == crypto_aead_xchacha20poly1305_ietf_ABYTES);

// The upper bits of `kind` say which layout this is, so that a later one is refused and not misread.
constexpr std::uint8_t kSealFormat = 0x30, kSealHandshakeBit = 0x01, kSealHoldsNewerBit = 0x02;

constexpr std::array<std::uint8_t, 11> kNonceDomain = {'g', '3', 'd', '-', 'f', 'l', 'e', 'e', 't', '-', '1'};
using SealNonce = std::array<std::uint8_t, crypto_aead_xchacha20poly1305_ietf_NPUBBYTES>;
static_assert(kNonceDomain.size() + 8 + 5 == std::tuple_size_v<SealNonce>);

/// Session and counter stand behind each other on the wire as in the nonce.
SealNonce nonce_from_header(const std::uint8_t* header) {
  SealNonce nonce;
  std::copy(kNonceDomain.begin(), kNonceDomain.end(), nonce.begin());
  std::memcpy(nonce.data() + kNonceDomain.size(), header + 2, 8 + 5);
  return nonce;
}

}  // namespace

SenderStart fresh_sender_start() { return {random_u64(), 0}; }

Sealer::Sealed Sealer::seal(DatagramKind kind, std::uint16_t epoch, const SecretKey& key,
                            std::span<const std::uint8_t> plaintext, DatagramBuffer out) {
  if (plaintext.size() > kMostPlaintext_bytes) return {SealVerdict::too_long};
  if (counter_ > kMostCounter) return {SealVerdict::exhausted};
  std::uint8_t* const header = out.data();
  header[0] = static_cast<std::uint8_t>(kSealFormat | (kind.handshake ? kSealHandshakeBit : 0) |
                                        (kind.holds_newer ? kSealHoldsNewerBit : 0));
  header[1] = static_cast<std::uint8_t>(epoch);
  std::memcpy(header + 2, &session_, 8);
  std::memcpy(header + 10, &counter_, 5);
  ++counter_;
  const SealNonce nonce = nonce_from_header(header);
  std::uint8_t* const ciphertext = header + kEnvelopeHeader_bytes;
  crypto_aead_xchacha20poly1305_ietf_encrypt(ciphertext, nullptr, plaintext.data(), plaintext.size(), header,
                                             kEnvelopeHeader_bytes, nullptr, nonce.data(), key.data());
  return {SealVerdict::sealed, kEnvelope_bytes + plaintext.size()};
}

Envelope Opener::look(std::span<const std::uint8_t> datagram) const {
  Envelope envelope;
  const auto refuse = [&envelope](OpenVerdict verdict) {
    envelope.verdict = verdict;
    return envelope;
  };
  if (datagram.size() < kEnvelope_bytes) return refuse(OpenVerdict::too_short);
  if (datagram.size() > kMostDatagram_bytes) return refuse(OpenVerdict::too_long);
  if ((datagram[0] & ~(kSealHandshakeBit | kSealHoldsNewerBit)) != kSealFormat) {
    return refuse(OpenVerdict::unknown_format);
  }
  const bool is_current = datagram[1] == static_cast<std::uint8_t>(keys_.epoch);
  const bool is_previous = keys_.previous && datagram[1] == static_cast<std::uint8_t>(keys_.previous_epoch());
  if (!is_current && !is_previous) return refuse(OpenVerdict::unknown_epoch);
  envelope.kind = {(datagram[0] & kSealHandshakeBit) != 0, (datagram[0] & kSealHoldsNewerBit) != 0};
  envelope.previous_epoch = is_previous;
  std::memcpy(&envelope.session, datagram.data() + 2, 8);
  std::memcpy(&envelope.counter, datagram.data() + 10, 5);
  return refuse(OpenVerdict::opened);
}

Opener::Opened Opener::open(std::span<const std::uint8_t> datagram, DatagramBuffer out) const {
  Opened opened{look(datagram), {}};
  if (opened.envelope.verdict != OpenVerdict::opened) return opened;
  const SecretKey& key = opened.envelope.previous_epoch ? *keys_.previous : keys_.key;
  const SealNonce nonce = nonce_from_header(datagram.data());
  const int failed = crypto_aead_xchacha20poly1305_ietf_decrypt(
      out.data(), nullptr, nullptr, datagram.data() + kEnvelopeHeader_bytes, datagram.size() - kEnvelopeHeader_bytes,
      datagram.data(), kEnvelopeHeader_bytes, nonce.data(), key.data());
  if (failed != 0) {
    opened.envelope.verdict = OpenVerdict::forged;
    return opened;
  }
  opened.plaintext = out.first(datagram.size() - kEnvelope_bytes);
  return opened;
}

}  // namespace g3d::net
