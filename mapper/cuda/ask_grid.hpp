// SPDX-License-Identifier: Apache-2.0
// Travel costs over a grid, by a card. Nobody's map is concerned, so it may be asked at any time.
#pragma once

#include <cstdint>
#include <span>

#include "mapper/cuda/card.hpp"

namespace g3d::mapper::cuda {

/// A cost and a distance for every cell, row by row. False: there is no room for so large a grid, the start is outside,
/// or the card is lost (it failed, or said what cannot be); the distances are meaningless then.
[[nodiscard]] bool ask_grid(Card& card, const GridSpread& spread, std::span<const std::uint8_t> costs,
                            std::span<std::uint32_t> distances);

}  // namespace g3d::mapper::cuda
