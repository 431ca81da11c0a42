// SPDX-License-Identifier: Apache-2.0
// Which datagrams of one session have been seen: each counter is fresh once, in any order, as long as it is less than
// 1024 behind the highest one. Ask after a datagram is authenticated, never before. One thread; nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace g3d::net {

enum class Freshness : std::uint8_t {
  fresh,
  replayed,  ///< seen before, or from before the window began
  too_old,   ///< beyond the window: nobody knows
};

class ReplayWindow {
 public:
  static constexpr std::uint64_t kWidth = 1024;

  /// Begins with `counter` as seen, and all before it as well.
  void begin_at(std::uint64_t counter);
  /// Counters are below 2^40.
  [[nodiscard]] Freshness take(std::uint64_t counter);
  [[nodiscard]] std::uint64_t highest() const { return highest_; }

 private:
  static constexpr std::uint64_t kWordBits = 64;
  [[nodiscard]] std::uint64_t& word_of(std::uint64_t counter) { return seen_[counter % kWidth / kWordBits]; }
  [[nodiscard]] static std::uint64_t bit_of(std::uint64_t counter) { return std::uint64_t{1} << counter % kWordBits; }

  std::uint64_t highest_ = 0;
  std::array<std::uint64_t, kWidth / kWordBits> seen_{};  ///< a ring: bit counter % kWidth
};

}  // namespace g3d::net
