// SPDX-License-Identifier: Apache-2.0
// The machine under the kernels, for clang's PTX: what they use of a GPU and nothing more. No CUDA toolkit is needed.
// target_host.hpp says the same for a processor; a kernel source sees one of the two.
#pragma once

#include <cstdint>

#define G3D_GPU __attribute__((device, always_inline))
#define G3D_GPU_SHARED __attribute__((shared))

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kWholeWarp = 0xFFFFFFFFU;

/// One or more warps of 32 threads of a block that work on the same thing.
template <int kWarps>
class Team {
 public:
  static constexpr int kThreads = 32 * kWarps;
  G3D_GPU Team(int block_index, int block_count) {
    const int here = static_cast<int>(__nvvm_read_ptx_sreg_ntid_x()) / kThreads;
    thread_ = static_cast<int>(__nvvm_read_ptx_sreg_tid_x()) % kThreads;
    in_block = static_cast<int>(__nvvm_read_ptx_sreg_tid_x()) / kThreads;
    index = block_index * here + in_block;
    count = block_count * here;
  }
  /// f(thread) for every thread of the team; all have returned before the next line runs, and see what others wrote.
  template <typename F>
  G3D_GPU void each(F&& f) const {
    f(thread_);
    if (kWarps == 1) {
      __nvvm_bar_warp_sync(kWholeWarp);
    } else {
      __syncthreads();
    }
  }
  /// The same, but for what is told through a PerThread alone.
  template <typename F>
  G3D_GPU void lanes(F&& f) const {
    f(thread_);
  }
  int index;     ///< among the teams of the launch
  int count;     ///< of them
  int in_block;  ///< index among the block's teams

 private:
  int thread_;
};

/// One block of threads of a launch.
class Block {
 public:
  G3D_GPU Block()
      : index(static_cast<int>(__nvvm_read_ptx_sreg_ctaid_x())),
        count(static_cast<int>(__nvvm_read_ptx_sreg_nctaid_x())) {}
  /// f(thread) for every thread of the block; all have returned before the next line runs.
  template <typename F>
  G3D_GPU void each(F&& f) const {
    f(static_cast<int>(__nvvm_read_ptx_sreg_tid_x()));
    __syncthreads();
  }
  template <typename F>
  G3D_GPU void lanes(F&& f) const {
    f(static_cast<int>(__nvvm_read_ptx_sreg_tid_x()));
  }
  /// f(team) for every team of the block, which then go their own ways.
  template <int kWarps, typename F>
  G3D_GPU void teams(F&& f) const {
    f(Team<kWarps>(index, count));
  }
  int index;
  int count;
};

/// A value that each thread keeps from one each() to the next. The 32 threads of a warp may look at each other's, all
/// at once, in the step after the one in which they were set.
template <typename T, int kThreads>
class PerThread {
 public:
  G3D_GPU T& operator[](int) { return value_; }
  /// Of the thread whose number differs in these bits.
  G3D_GPU T peer(int, int bits) const {
    return static_cast<T>(__nvvm_shfl_sync_bfly_i32(kWholeWarp, static_cast<int>(value_), bits, 31));
  }
  /// Of a lane of the thread's warp.
  G3D_GPU T of(int, int lane) const {
    return static_cast<T>(__nvvm_shfl_sync_idx_i32(kWholeWarp, static_cast<int>(value_), lane, 31));
  }
  /// Lanes of the thread's warp where it is not 0.
  G3D_GPU std::uint32_t ballot(int) const { return __nvvm_vote_ballot_sync(kWholeWarp, value_ != 0); }

 private:
  T value_;
};

inline G3D_GPU std::uint32_t atomic_add(std::uint32_t* p, std::uint32_t v) {
  return static_cast<std::uint32_t>(__nvvm_atom_add_gen_i(reinterpret_cast<int*>(p), static_cast<int>(v)));
}
inline G3D_GPU std::int64_t atomic_add_long(std::int64_t* p, std::int64_t v) {
  return __nvvm_atom_add_gen_ll(reinterpret_cast<long long*>(p), v);
}
/// What the thread wrote before is seen by all others before what it writes after.
inline G3D_GPU void fence() { __nvvm_membar_gl(); }
inline G3D_GPU std::uint32_t atomic_or(std::uint32_t* p, std::uint32_t v) {
  return static_cast<std::uint32_t>(__nvvm_atom_or_gen_i(reinterpret_cast<int*>(p), static_cast<int>(v)));
}
inline G3D_GPU std::uint32_t atomic_min(std::uint32_t* p, std::uint32_t v) { return __nvvm_atom_min_gen_ui(p, v); }
inline G3D_GPU std::uint32_t atomic_cas(std::uint32_t* p, std::uint32_t expected, std::uint32_t v) {
  return static_cast<std::uint32_t>(
      __nvvm_atom_cas_gen_i(reinterpret_cast<int*>(p), static_cast<int>(expected), static_cast<int>(v)));
}
inline G3D_GPU std::uint64_t atomic_cas(std::uint64_t* p, std::uint64_t expected, std::uint64_t v) {
  return static_cast<std::uint64_t>(__nvvm_atom_cas_gen_ll(
      reinterpret_cast<long long*>(p), static_cast<long long>(expected), static_cast<long long>(v)));
}

}  // namespace g3d::mapper::cuda
