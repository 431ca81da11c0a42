// SPDX-License-Identifier: Apache-2.0
// What a coder expects of the next bit: a probability that starts where maps taught it (block_tables.hpp) and follows
// the bits of this block, fast at first and slower the more it has seen. Three of them that look at the bit from
// different sides are mixed as in PAQ: their odds are multiplied, each to the power of its weight.
//
// All of it is integer arithmetic on tables that the compiler makes: the same on every machine.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace g3d::net {

inline constexpr int kProbabilityBits = 16;
inline constexpr std::uint32_t kProbabilityMask = 0xFFFF;
inline constexpr std::uint32_t kEven = 1U << (kProbabilityBits - 1);

/// Logits are in 1/256: -2047..2047 is what 12 bits of a probability can tell apart.
inline constexpr int kMaxLogit = 2047;

constexpr std::array<std::uint16_t, 2 * kMaxLogit + 1> make_squash() {
  constexpr std::array<int, 33> kAt{1,    2,    3,    6,    10,   16,   27,   45,   73,   120,  194,
                                    310,  488,  747,  1101, 1546, 2047, 2549, 2994, 3348, 3607, 3785,
                                    3901, 3975, 4022, 4050, 4068, 4079, 4085, 4089, 4092, 4093, 4094};
  std::array<std::uint16_t, 2 * kMaxLogit + 1> table{};
  for (int logit = -kMaxLogit; logit <= kMaxLogit; ++logit) {
    const int part = logit & 127;
    const auto at = static_cast<std::size_t>(std::ptrdiff_t{logit >> 7} + 16);
    const int p = (kAt[at] * (128 - part) + kAt[at + 1] * part + 64) >> 7;
    table[static_cast<std::size_t>(std::ptrdiff_t{logit} + kMaxLogit)] = static_cast<std::uint16_t>(p);
  }
  return table;
}
inline constexpr std::array<std::uint16_t, 2 * kMaxLogit + 1> kSquash = make_squash();

/// Of a logit from -kMaxLogit to kMaxLogit, in 4096ths: 4096 / (1 + e^(-logit / 256)), from 33 values and straight
/// lines between.
[[nodiscard]] constexpr int squash(int logit) {
  return kSquash[static_cast<std::size_t>(std::ptrdiff_t{logit} + kMaxLogit)];
}

constexpr std::array<std::int16_t, 4096> make_stretch() {
  std::array<std::int16_t, 4096> table{};
  int next = 0;
  for (int logit = -kMaxLogit; logit <= kMaxLogit; ++logit) {
    const int p = squash(logit);
    for (; next <= p; ++next) table[static_cast<std::size_t>(next)] = static_cast<std::int16_t>(logit);
  }
  for (; next < 4096; ++next) table[static_cast<std::size_t>(next)] = kMaxLogit;
  return table;
}
inline constexpr std::array<std::int16_t, 4096> kStretch = make_stretch();

constexpr std::array<std::uint16_t, 256> make_rates() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t n = 0; n < table.size(); ++n) table[n] = static_cast<std::uint16_t>(65536U * 2U / (2U * n + 3U));
  return table;
}
/// 1 / (n + 1.5) in 65536ths.
inline constexpr std::array<std::uint16_t, 256> kRates = make_rates();

struct BitModel {
  std::uint16_t probability = kEven;  ///< of a set bit, 16..65519
  std::uint8_t seen = 0;              ///< how much it has seen, or counts as having seen
  std::uint8_t most = 255;            ///< it never counts as more, so that it goes on following
  std::uint32_t epoch = 0;            ///< the block that it was last used for (block_models.hpp)

  void learn(bool bit) {
    const std::int64_t missed = (bit ? 65519 : 16) - probability;
    probability = static_cast<std::uint16_t>(probability + ((missed * kRates[seen]) >> 16));
    seen = static_cast<std::uint8_t>(seen + (seen < most ? 1 : 0));
  }
  [[nodiscard]] std::int32_t logit() const { return kStretch[probability >> 4]; }
};

inline constexpr std::size_t kMixed = 3;

/// How much each model of a mix is trusted, in 65536ths; that learns from every bit as well.
struct MixWeights {
  std::array<std::int32_t, kMixed> of{};
};

/// Three models that look at one bit.
struct Mixed {
  std::array<BitModel*, kMixed> models;
  MixWeights* weights;
  std::array<std::int32_t, kMixed> logits{};
  std::int32_t expected = 0;  ///< in 4096ths

  // No loops: g++ unrolls none at -O2, and this is where the time goes.
  std::uint32_t probability() {
    logits = {models[0]->logit(), models[1]->logit(), models[2]->logit()};
    const std::int64_t sum = std::int64_t{logits[0]} * weights->of[0] + std::int64_t{logits[1]} * weights->of[1] +
                             std::int64_t{logits[2]} * weights->of[2];
    expected = squash(static_cast<int>(std::clamp<std::int64_t>(sum >> 16, -kMaxLogit, kMaxLogit)));
    return static_cast<std::uint32_t>(expected) << 4;
  }
  /// 512 voxels move a weight by 512 * 12300 at most: 32 bits are enough.
  void learn(bool bit) const {
    constexpr std::int32_t kRate = 12;  // found by trial
    const std::int32_t missed = ((bit ? 4095 : 0) - expected) * kRate;
    weights->of[0] += (logits[0] * missed) >> 14;
    weights->of[1] += (logits[1] * missed) >> 14;
    weights->of[2] += (logits[2] * missed) >> 14;
    models[0]->learn(bit);
    models[1]->learn(bit);
    models[2]->learn(bit);
  }
};

}  // namespace g3d::net
