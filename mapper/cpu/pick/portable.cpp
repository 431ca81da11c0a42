// SPDX-License-Identifier: Apache-2.0
// Machines whose every processor has the vector unit that the compiler assumes (aarch64): one variant, no choice.
#include "mapper/cpu/kernels/kernels.hpp"

namespace g3d::mapper::cpu {
namespace baseline {
const Kernels& table();
}

const Kernels& kernels_by_name(const char*) { return baseline::table(); }
const Kernels& best_kernels() { return baseline::table(); }

}  // namespace g3d::mapper::cpu
