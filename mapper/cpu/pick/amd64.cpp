// SPDX-License-Identifier: Apache-2.0
// Which instruction set this amd64 processor has. The toolchain file names this source; other machines have one
// variant.
#include <cstring>

#include "mapper/cpu/kernels/kernels.hpp"

namespace g3d::mapper::cpu {
namespace baseline {
const Kernels& table();
}
namespace avx2 {
const Kernels& table();
}
namespace avx512 {
const Kernels& table();
}

namespace {

// f16c came with AVX2 in every processor; clang 14 cannot ask for it by name. lzcnt did too, but some virtual machines
// hide it: nothing is compiled for it.
bool has_avx2() {
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
         __builtin_cpu_supports("bmi2") != 0 && __builtin_cpu_supports("popcnt") != 0;
}
bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
         __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0;
}

}  // namespace

const Kernels& kernels_by_name(const char* name) {
  if (std::strcmp(name, "avx512") == 0 && has_avx512()) return avx512::table();
  if (std::strcmp(name, "avx2") == 0 && has_avx2()) return avx2::table();
  return baseline::table();
}

const Kernels& best_kernels() {
  return has_avx512() ? avx512::table() : has_avx2() ? avx2::table() : baseline::table();
}

}  // namespace g3d::mapper::cpu
