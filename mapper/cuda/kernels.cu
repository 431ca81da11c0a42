// SPDX-License-Identifier: Apache-2.0
// The kernels' entry points, compiled by clang to PTX without a CUDA toolkit (see the Makefile).
#include "mapper/cuda/target_ptx.hpp"
//
#include "mapper/cuda/kernels/launches.hpp"

#define G3D_KERNEL extern "C" __attribute__((global)) void

using namespace g3d::mapper::cuda;

/// Filled by whoever owns the memory, before the first launch. All threads read the same pointer at once: what constant
/// memory is for.
extern "C" {
__attribute__((constant)) Memory memory_map;
}

G3D_KERNEL import_blocks_kernel(const Parcels in, std::uint32_t count) {
  import_blocks(Block{}, memory_map, in, count);
}
G3D_KERNEL scan_image_kernel() { scan_image(Block{}, memory_map); }
G3D_KERNEL reduce_image_kernel() { reduce_image(Block{}, memory_map); }
G3D_KERNEL walk_image_kernel() { walk_image(Block{}, memory_map); }
G3D_KERNEL find_work_kernel() { find_work(Block{}, memory_map); }
G3D_KERNEL update_map_kernel() { update_map(Block{}, memory_map); }
G3D_KERNEL export_blocks_kernel(const Parcels out, FrameCounters* counters, std::uint32_t first, std::uint32_t room) {
  export_blocks(Block{}, memory_map, out, counters, first, room);
}
