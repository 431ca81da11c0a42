// SPDX-License-Identifier: Apache-2.0
// The kernels' entry points, compiled by clang to PTX without a CUDA toolkit (see the Makefile).
#include "mapper/cuda/target_ptx.hpp"
//
// What alignment does by CPU and card alike is ordinary code: here it is compiled for the card as well.
#include <array>
#include <cstddef>
#include <limits>
#pragma clang force_cuda_host_device begin
#include "mapper/align/pose_fit.hpp"
#pragma clang force_cuda_host_device end
//
#include "mapper/cuda/kernels/launches.hpp"

// So many registers that this many blocks of threads share a multiprocessor: they wait for memory most of the time.
#define G3D_KERNEL(threads, blocks) extern "C" __attribute__((global, launch_bounds(threads, blocks))) void

using namespace g3d::mapper::cuda;

/// Filled by whoever owns the memory, before the first launch and before each frame. All threads read the same word at
/// once: what constant memory is for.
extern "C" {
__attribute__((constant)) Memory memory_map;
__attribute__((constant)) FrameParams frame_params;
}

G3D_KERNEL(kParcelThreads, 8) import_blocks_kernel(const Parcels in, std::uint32_t count) {
  import_blocks(Block{}, memory_map, in, count);
}
G3D_KERNEL(kPixelThreads, 4) read_image_kernel() { read_image(Block{}, memory_map, frame_params); }
G3D_KERNEL(kPixelThreads, 6) walk_image_kernel() { walk_image(Block{}, memory_map, frame_params); }
G3D_KERNEL(kPixelThreads, 4) find_work_kernel() { find_work(Block{}, memory_map, frame_params); }
G3D_KERNEL(kUpdateThreads, 6) update_map_1_kernel() { update_map<1>(Block{}, memory_map, frame_params); }
G3D_KERNEL(kUpdateThreads, 6) update_map_4_kernel() { update_map<4>(Block{}, memory_map, frame_params); }
G3D_KERNEL(kParcelThreads, 8) export_classes_kernel(const Classes out, FrameCounters* counters, std::uint32_t room) {
  export_classes(Block{}, memory_map, frame_params, out, counters, room);
}
G3D_KERNEL(kParcelThreads, 8) export_blocks_kernel(const Parcels out, std::uint32_t first, std::uint32_t room) {
  export_blocks(Block{}, memory_map, out, first, room);
}
G3D_KERNEL(kParcelThreads, 8) cast_rays_kernel(float resolution_m, std::uint32_t count) {
  cast_rays(Block{}, memory_map, resolution_m, count);
}
G3D_KERNEL(kParcelThreads, 8) read_columns_kernel(std::uint32_t first, std::uint32_t room) {
  read_columns(Block{}, memory_map, first, room);
}
G3D_KERNEL(kPixelThreads, 4) mark_looks_kernel(const g3d::mapper::LookModel model, std::uint32_t count) {
  mark_looks(Block{}, memory_map, model, count);
}
G3D_KERNEL(kPixelThreads, 4) begin_spread_kernel() { begin_spread(Block{}, memory_map); }
G3D_KERNEL(kPixelThreads, 4) spread_round_kernel(std::uint32_t round) { spread_round(Block{}, memory_map, round); }
G3D_KERNEL(kPixelThreads, 4) count_looks_kernel(std::uint32_t count) { count_looks(Block{}, memory_map, count); }
G3D_KERNEL(kPixelThreads, 4) read_tiles_kernel() { read_tiles(Block{}, memory_map); }
G3D_KERNEL(kPixelThreads, 4) find_samples_kernel() { find_samples(Block{}, memory_map); }
G3D_KERNEL(kPixelThreads, 4) count_chosen_kernel() { count_chosen(Block{}, memory_map); }
G3D_KERNEL(kPixelThreads, 4) choose_kernel() { choose(Block{}, memory_map); }
G3D_KERNEL(kParcelThreads, 4) match_step_kernel(int step) { match_step(Block{}, memory_map, step); }
G3D_KERNEL(kPixelThreads, 4) place_samples_kernel() { place_samples(Block{}, memory_map); }
G3D_KERNEL(kPixelThreads, 4) lead_cells_kernel() { lead_cells(Block{}, memory_map); }
G3D_KERNEL(kPixelThreads, 4) add_samples_kernel() { add_samples(Block{}, memory_map); }
G3D_KERNEL(kPixelThreads, 4) sweep_cells_kernel() { sweep_cells(Block{}, memory_map); }
G3D_KERNEL(kPixelThreads, 4) export_cells_kernel(std::uint32_t room) { export_cells(Block{}, memory_map, room); }
G3D_KERNEL(kPixelThreads, 4) import_cells_kernel(std::uint32_t first, std::uint32_t count) {
  import_cells(Block{}, memory_map, first, count);
}
