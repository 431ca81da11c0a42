// SPDX-License-Identifier: Apache-2.0
// Every set of kernels that this machine runs.
#pragma once

#include <algorithm>
#include <vector>

#include "mapper/cpu/kernels/kernels.hpp"

namespace g3d::test {

[[nodiscard]] inline std::vector<const mapper::cpu::Kernels*> kernel_variants() {
  std::vector<const mapper::cpu::Kernels*> variants;
  for (const char* name : {"baseline", "avx2", "avx512"}) {
    const mapper::cpu::Kernels* kernels = &mapper::cpu::kernels_by_name(name);
    if (std::find(variants.begin(), variants.end(), kernels) == variants.end()) variants.push_back(kernels);
  }
  return variants;
}

}  // namespace g3d::test
