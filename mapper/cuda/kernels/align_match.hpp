// SPDX-License-Identifier: Apache-2.0
// One step of align::fit(): a thread for each chosen sample, sums of whole numbers in any order, and the last block of
// threads to arrive takes the step. Steps after the last one do nothing.
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

inline constexpr int kSumCount = 30;  ///< numbers in NormalSums
inline constexpr int kSumParts = 4;   ///< threads that add up the same one
static_assert(sizeof(align::NormalSums) == kSumCount * sizeof(std::int64_t));
static_assert(kSumCount * kSumParts <= kParcelThreads);

struct CardSurfaces {
  const AlignMemory& a;
  G3D_GPU const align::SurfaceCell* operator()(std::uint64_t key) const {
    auto at = static_cast<std::uint32_t>(align::home_of(key, a.slot_mask));
    for (;;) {
      const std::uint64_t stored = a.cells[at].key;
      if (stored == key) return a.cells + at;
      if (stored == 0) return nullptr;
      at = (at + 1) & a.slot_mask;
    }
  }
};

struct MatchShare {
  std::int64_t sums[kSumCount][kParcelThreads + 1];
  std::uint32_t is_last;
};

inline G3D_GPU void match_step(const Block& block, const Memory& m, int step) {
  G3D_GPU_SHARED MatchShare s;
  const AlignMemory& a = m.align;
  const AlignQuestion& question = *a.question;
  AlignState& state = *a.state;
  if (state.ended != 0) return;  // nobody ends it before all have arrived
  using AnyLong [[gnu::may_alias]] = std::int64_t;
  block.each([&](int t) {
    align::NormalSums own;
    const auto stride = static_cast<std::uint32_t>(block.count * kParcelThreads);
    for (auto i = static_cast<std::uint32_t>(block.index * kParcelThreads + t); i < state.chosen; i += stride) {
      align::add_match(a.chosen[i], state.T_world_camera, question.rule, question.fit.kernel_m, question.fit.born_by_ns,
                       CardSurfaces{a}, own);
    }
#pragma GCC unroll 21
    for (int i = 0; i < 21; ++i) s.sums[i][t] = own.upper[static_cast<std::size_t>(i)];
#pragma GCC unroll 6
    for (int i = 0; i < 6; ++i) s.sums[21 + i][t] = own.gradient[static_cast<std::size_t>(i)];
    s.sums[27][t] = own.square;
    s.sums[28][t] = own.cost;
    s.sums[29][t] = own.matched;
  });
  block.each([&](int t) {
    if (t < kSumCount * kSumParts) {
      std::int64_t sum = 0;
      for (int i = t % kSumParts; i < kParcelThreads; i += kSumParts) sum += s.sums[t / kSumParts][i];
      auto* const total = reinterpret_cast<AnyLong*>(&state.sums[step]) + t / kSumParts;
      if (sum != 0) atomic_add_long(total, sum);
    }
    fence();
  });
  block.each([&](int t) {
    if (t != 0) return;
    s.is_last = atomic_add(state.arrived + step, 1U) + 1 == static_cast<std::uint32_t>(block.count) ? 1 : 0;
    fence();
  });
  if (s.is_last == 0) return;
  block.each([&](int t) {
    if (t != 0) return;
    hal::Pose pose = state.pose;
    state.steps = static_cast<std::uint32_t>(step);
    if (align::take_step(state.sums[step], static_cast<double>(state.chosen), question.fit, step, pose)) {
      state.pose = pose;
      state.T_world_camera = hal::to_transform(pose);
    } else {
      state.ended = 1;
    }
  });
}

}  // namespace g3d::mapper::cuda
