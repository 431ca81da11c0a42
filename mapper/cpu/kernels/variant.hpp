// SPDX-License-Identifier: Apache-2.0
// Included by the kernel sources only: declares them inside the namespace of the instruction set they are compiled for.
#pragma once

#include "mapper/cpu/kernels/kernels.hpp"

namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT {

/// Of this instruction set's registers. The compiler takes wider vectors apart into single numbers.
inline constexpr int kVectorBytes = G3D_VECTOR_BYTES;

RowCounts classify_row(const ClassifyRow& row);
void carry_down(const std::uint16_t* depth, int count, std::uint16_t* last, std::uint16_t* ends);
void bound_up(const BoundRow& row);
void unproject_row(const UnprojectRow& row);
void drop_repeats(const std::uint32_t* code, const std::uint32_t* code_above, int width, std::uint8_t* starts);
void max_filter_row(const std::uint16_t* a, const std::uint16_t* b, int shift, int count, std::uint16_t* out);
void halve_max_row(const std::uint16_t* a, const std::uint16_t* b, int count, std::uint16_t* out);
void halve_min_row(const std::uint16_t* a, const std::uint16_t* b, int count, std::uint16_t* out);
void bound_boxes(const BoxView& view, int count, BoxBounds& boxes);
bool project_brick(const ProjectBrick& brick, std::uint8_t* free);
ApplyResult apply_block(const ApplyBlock& block);
bool any_contested(const std::uint8_t* levels, const std::uint8_t* hits, const std::uint8_t* free);
bool sort_brick(const SortBrick& brick, std::uint8_t* sorted);
bool find_ray(const RaySearch& search, const std::int32_t* voxel, bool strong);
void walk_rays(const RayRow& row);
void walk_bresenham(const RayRow& row);
const Kernels& table();

}  // namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT
