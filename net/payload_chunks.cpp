// SPDX-License-Identifier: Apache-2.0
#include "net/payload_chunks.hpp"

#include <algorithm>
#include <cstring>

namespace g3d::net {

bool PayloadChunks::put(mapper::ByteSpan bytes, std::uint32_t& chain) {
  chain = kNone;
  const std::size_t needed = chunks_of(bytes.size());
  if (needed > pool_.available()) return false;
  // From the last to the first, so that every chunk knows the next one when it is written.
  for (std::size_t i = needed; i-- > 0;) {
    const std::uint32_t slot = pool_.take();
    Chunk& chunk = pool_[slot];
    const mapper::ByteSpan piece = bytes.subspan(i * kChunk_bytes);
    std::memcpy(chunk.bytes, piece.data(), std::min(kChunk_bytes, piece.size()));
    chunk.next = chain;
    chain = slot;
  }
  return true;
}

void PayloadChunks::get(std::uint32_t chain, std::span<std::uint8_t> out) const {
  for (std::size_t at = 0; at < out.size(); at += kChunk_bytes) {
    const Chunk& chunk = pool_[chain];
    std::memcpy(out.data() + at, chunk.bytes, std::min(kChunk_bytes, out.size() - at));
    chain = chunk.next;
  }
}

bool PayloadChunks::equals(std::uint32_t chain, mapper::ByteSpan bytes) const {
  for (std::size_t at = 0; at < bytes.size(); at += kChunk_bytes) {
    if (chain == kNone) return false;
    const Chunk& chunk = pool_[chain];
    if (std::memcmp(bytes.data() + at, chunk.bytes, std::min(kChunk_bytes, bytes.size() - at)) != 0) return false;
    chain = chunk.next;
  }
  return chain == kNone;
}

void PayloadChunks::drop(std::uint32_t chain) {
  while (chain != kNone) {
    const std::uint32_t next = pool_[chain].next;
    pool_.give_back(chain);
    chain = next;
  }
}

}  // namespace g3d::net
