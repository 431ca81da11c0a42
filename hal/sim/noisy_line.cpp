// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/noisy_line.hpp"

namespace g3d::hal {

NoisyLine::NoisyLine(std::uint64_t seed) : random_(seed), bytes_(kCapacity_bytes), due_ns_(kCapacity_bytes) {}

void NoisyLine::put(std::uint8_t byte, TimeNs due_ns) {
  bytes_[tail_ % kCapacity_bytes] = byte;
  due_ns_[tail_ % kCapacity_bytes] = due_ns;
  ++tail_;
}

bool NoisyLine::push(std::span<const std::uint8_t> bytes, TimeNs now_ns) {
  // Every byte may bring one that was not sent.
  if (tail_ - head_ + 2 * bytes.size() > kCapacity_bytes) return false;
  for (const std::uint8_t byte : bytes) {
    const TimeNs due_ns = now_ns + noise_.latency_ns;
    if (random_.happens(noise_.insert)) put(static_cast<std::uint8_t>(random_.bits()), due_ns);
    if (random_.happens(noise_.lose)) continue;
    std::uint8_t sent = byte;
    if (random_.happens(noise_.corrupt)) sent ^= static_cast<std::uint8_t>(1 + random_.bits() % 255);
    put(sent, due_ns);
  }
  return true;
}

std::size_t NoisyLine::pop(std::span<std::uint8_t> into, TimeNs now_ns) {
  std::size_t count = 0;
  while (count < into.size() && head_ != tail_ && due_ns_[head_ % kCapacity_bytes] <= now_ns) {
    into[count++] = bytes_[head_++ % kCapacity_bytes];
  }
  return count;
}

}  // namespace g3d::hal
