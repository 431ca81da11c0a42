// SPDX-License-Identifier: Apache-2.0
// Chance that repeats: SplitMix64 (Steele, Lea and Flood 2014), the same on every machine.
#pragma once

#include <cstdint>

namespace g3d::hal {

class SeededRandom {
 public:
  explicit SeededRandom(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t x = state_;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
    return x ^ (x >> 31);
  }
  /// In [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  /// Nearly Gaussian, mean 0, sigma 1: the sum of twelve uniform numbers less six.
  double gaussian() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
  /// A chance of 0 draws nothing, so that what is switched off does not shift what is on.
  bool happens(double chance) { return chance > 0.0 && uniform() < chance; }

 private:
  std::uint64_t state_;
};

}  // namespace g3d::hal
