// SPDX-License-Identifier: Apache-2.0
// Datagrams that travel in one message of a broker, so that they share what it puts around each message. One after the
// other, each behind its length:  u16 length | length bytes. As sealed datagrams they need no checksum.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mapper/files/bytes.hpp"
#include "net/datagram_seal.hpp"

namespace g3d::net {

inline constexpr std::size_t kBatchedLength_bytes = 2;

/// `datagram`: 1 to kMostDatagram_bytes.
void append_datagram(mapper::Bytes& batch, mapper::ByteSpan datagram);

/// How many datagrams there are; 0 if the batch is not whole, or one of them is empty or longer than
/// kMostDatagram_bytes.
[[nodiscard]] std::size_t datagrams_of(mapper::ByteSpan batch);

/// All datagrams of a batch of which datagrams_of() is not 0, in their order: visit(mapper::ByteSpan).
template <class Visit>
void visit_datagrams(mapper::ByteSpan batch, Visit&& visit) {
  mapper::ByteReader reader(batch);
  std::uint16_t size_bytes = 0;
  mapper::ByteSpan datagram;
  while (reader.take(size_bytes) && reader.take_bytes(size_bytes, datagram)) visit(datagram);
}

}  // namespace g3d::net
