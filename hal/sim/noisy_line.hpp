// SPDX-License-Identifier: Apache-2.0
// One direction of a simulated serial line: bytes arrive later, and some arrive wrong, not at all, or without having
// been sent. With everything at 0 it is a plain queue. One thread; nothing is allocated after construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/seeded_random.hpp"

namespace g3d::hal {

/// Chances are per byte, 0..1.
struct LineNoise {
  double corrupt = 0.0;  ///< one to eight bits turn over
  double lose = 0.0;
  double insert = 0.0;  ///< a random byte before it
  TimeNs latency_ns = 0;
  bool operator==(const LineNoise&) const = default;
};

class NoisyLine {
 public:
  static constexpr std::size_t kCapacity_bytes = 1 << 14;  ///< as much as a kernel's buffers hold, and some more

  explicit NoisyLine(std::uint64_t seed);

  /// From now on; what is under way is not touched.
  void set_noise(const LineNoise& noise) { noise_ = noise; }
  /// False if the queue is full: then nothing was taken.
  [[nodiscard]] bool push(std::span<const std::uint8_t> bytes, TimeNs now_ns);
  /// What has arrived by now, at most `into.size()` bytes.
  [[nodiscard]] std::size_t pop(std::span<std::uint8_t> into, TimeNs now_ns);
  void clear() { head_ = tail_ = 0; }

 private:
  void put(std::uint8_t byte, TimeNs due_ns);

  LineNoise noise_;
  SeededRandom random_;
  std::vector<std::uint8_t> bytes_;
  std::vector<TimeNs> due_ns_;
  std::size_t head_ = 0;  ///< both only grow; places are modulo the capacity
  std::size_t tail_ = 0;
};

}  // namespace g3d::hal
