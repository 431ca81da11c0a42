// SPDX-License-Identifier: Apache-2.0
#include "net/datagram_batch.hpp"

namespace g3d::net {

void append_datagram(mapper::Bytes& batch, mapper::ByteSpan datagram) {
  mapper::put(batch, static_cast<std::uint16_t>(datagram.size()));
  mapper::put_bytes(batch, datagram);
}

std::size_t datagrams_of(mapper::ByteSpan batch) {
  mapper::ByteReader reader(batch);
  std::size_t count = 0;
  while (reader.left() > 0) {
    std::uint16_t size_bytes = 0;
    mapper::ByteSpan datagram;
    if (!reader.take(size_bytes) || size_bytes == 0 || size_bytes > kMostDatagram_bytes) return 0;
    if (!reader.take_bytes(size_bytes, datagram)) return 0;
    ++count;
  }
  return count;
}

}  // namespace g3d::net
