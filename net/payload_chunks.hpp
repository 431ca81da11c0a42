// SPDX-License-Identifier: Apache-2.0
// Short byte strings of different lengths in memory that was reserved once: each is a chain of chunks of 32 bytes, so
// nothing ever has to be moved together. One thread.
#pragma once

#include <cstdint>
#include <span>

#include "mapper/files/bytes.hpp"
#include "mapper/pool.hpp"

namespace g3d::net {

class PayloadChunks {
 public:
  static constexpr std::uint32_t kNone = mapper::SlotPool<int>::kNone;

  explicit PayloadChunks(std::size_t budget_bytes)
      : pool_(static_cast<std::uint32_t>(budget_bytes / (sizeof(Chunk) + sizeof(std::uint32_t)))) {}

  /// False if there is no room; then nothing has changed. An empty string takes nothing, its chain is kNone.
  [[nodiscard]] bool put(mapper::ByteSpan bytes, std::uint32_t& chain);
  /// `out` is as long as what was put.
  void get(std::uint32_t chain, std::span<std::uint8_t> out) const;
  /// `bytes`: as long as what was put.
  [[nodiscard]] bool equals(std::uint32_t chain, mapper::ByteSpan bytes) const;
  void drop(std::uint32_t chain);
  /// Whether so many bytes could be put once a string of `dropped_bytes` was dropped.
  [[nodiscard]] bool has_room_for(std::size_t bytes, std::size_t dropped_bytes) const {
    return chunks_of(bytes) <= pool_.available() + chunks_of(dropped_bytes);
  }

  [[nodiscard]] std::size_t used_bytes() const { return std::size_t{pool_.in_use()} * sizeof(Chunk); }
  [[nodiscard]] std::size_t reserved_bytes() const { return pool_.reserved_bytes(); }

 private:
  static constexpr std::size_t kChunk_bytes = 28;
  [[nodiscard]] static constexpr std::size_t chunks_of(std::size_t bytes) {
    return (bytes + kChunk_bytes - 1) / kChunk_bytes;
  }
  struct Chunk {
    std::uint32_t next;
    std::uint8_t bytes[kChunk_bytes];
  };
  mapper::SlotPool<Chunk> pool_;
};

}  // namespace g3d::net
