// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/carried.hpp"

// The build says where the two files are.
#define G3D_CARRY(name, file)                                                                                          \
  asm(".pushsection .rodata\n.balign 16\n.globl " name "\n" name ":\n.incbin \"" file "\"\n.globl " name "_end\n" name \
      "_end:\n.byte 0\n.popsection\n")

G3D_CARRY("g3d_carried_helper", G3D_HELPER_FILE);
G3D_CARRY("g3d_carried_kernels", G3D_KERNELS_FILE);

extern "C" {
extern const std::byte g3d_carried_helper[];
extern const std::byte g3d_carried_helper_end[];
extern const char g3d_carried_kernels[];
extern const char g3d_carried_kernels_end[];
}

namespace g3d::mapper::cuda {

std::span<const std::byte> carried_helper() { return {g3d_carried_helper, g3d_carried_helper_end}; }

std::string_view carried_kernels() {
  return {g3d_carried_kernels, static_cast<std::size_t>(g3d_carried_kernels_end - g3d_carried_kernels)};
}

}  // namespace g3d::mapper::cuda
