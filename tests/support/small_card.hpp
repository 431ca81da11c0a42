// SPDX-License-Identifier: Apache-2.0
// An emulated card for a tiny camera and map, with room for a grid.
#pragma once

#include <cstdint>
#include <vector>

#include "mapper/cuda/emulated.hpp"

namespace g3d::test {

inline mapper::cuda::Emulated small_card(std::uint32_t grid_cells, std::uint64_t seed) {
  const std::vector<float> slopes(32, 0.0F);
  const std::vector<std::uint16_t> mask(32 * 24, 3000);
  mapper::cuda::MemorySizes sizes{32, 24, 512, 0, 256, 128, 128};
  sizes.grid_cells = grid_cells;
  return {sizes, slopes, std::span(slopes).first(24), mask, seed};
}

}  // namespace g3d::test
