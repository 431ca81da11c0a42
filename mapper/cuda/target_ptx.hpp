// SPDX-License-Identifier: Apache-2.0
// The machine under the kernels, for clang's PTX: what they use of a GPU and nothing more. No CUDA toolkit is needed.
// target_host.hpp says the same for a processor; a kernel source sees one of the two.
#pragma once

#include <cstdint>

#define G3D_GPU __attribute__((device, always_inline))
#define G3D_GPU_SHARED __attribute__((shared))

namespace g3d::mapper::cuda {

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
  int index;
  int count;
};

/// A value that each thread keeps from one each() to the next.
template <typename T, int kThreads>
class PerThread {
 public:
  G3D_GPU T& operator[](int) { return value_; }

 private:
  T value_;
};

inline G3D_GPU std::uint32_t atomic_add(std::uint32_t* p, std::uint32_t v) {
  return static_cast<std::uint32_t>(__nvvm_atom_add_gen_i(reinterpret_cast<int*>(p), static_cast<int>(v)));
}
inline G3D_GPU std::int32_t atomic_add(std::int32_t* p, std::int32_t v) { return __nvvm_atom_add_gen_i(p, v); }
inline G3D_GPU std::uint32_t atomic_or(std::uint32_t* p, std::uint32_t v) {
  return static_cast<std::uint32_t>(__nvvm_atom_or_gen_i(reinterpret_cast<int*>(p), static_cast<int>(v)));
}
inline G3D_GPU std::uint32_t atomic_min(std::uint32_t* p, std::uint32_t v) { return __nvvm_atom_min_gen_ui(p, v); }
inline G3D_GPU std::uint32_t atomic_max(std::uint32_t* p, std::uint32_t v) { return __nvvm_atom_max_gen_ui(p, v); }
inline G3D_GPU std::uint32_t atomic_cas(std::uint32_t* p, std::uint32_t expected, std::uint32_t v) {
  return static_cast<std::uint32_t>(
      __nvvm_atom_cas_gen_i(reinterpret_cast<int*>(p), static_cast<int>(expected), static_cast<int>(v)));
}
inline G3D_GPU std::uint64_t atomic_cas(std::uint64_t* p, std::uint64_t expected, std::uint64_t v) {
  return static_cast<std::uint64_t>(__nvvm_atom_cas_gen_ll(
      reinterpret_cast<long long*>(p), static_cast<long long>(expected), static_cast<long long>(v)));
}

}  // namespace g3d::mapper::cuda
