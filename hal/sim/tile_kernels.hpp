// SPDX-License-Identifier: Apache-2.0
// Rays of one 16x16 pixel tile against one solid: plain loops over floats that compilers turn into vector code. Ray
// parameter t is depth along the optical axis, because every ray direction has z = 1 in the camera frame.
#pragma once

#include <array>
#include <cstdint>

#include "hal/sim/world.hpp"

namespace g3d::hal {

inline constexpr int kTileSide_px = 16;
inline constexpr int kTilePixels = kTileSide_px * kTileSide_px;

/// A solid as seen from one camera pose.
struct PreparedSolid {
  Shape shape = Shape::box;
  std::array<float, 3> origin{};  ///< camera in the solid's own axes, from its centre
  std::array<float, 3> half{};
  float cos_yaw = 1.0F;
  float sin_yaw = 0.0F;
  float radius = 0.0F;         ///< sphere, cylinder; cone: at the height of its centre
  float slope = 0.0F;          ///< cone: change of radius with height
  float nearest_m = 0.0F;      ///< no ray meets it at a lower depth
  std::int32_t index = 0;      ///< in World::primitives
  std::int32_t tile_low[2]{};  ///< columns and rows of tiles that may see it, inclusive
  std::int32_t tile_high[2]{};
};

struct TileRays {
  alignas(64) std::array<float, kTilePixels> x;  ///< direction in the world
  alignas(64) std::array<float, kTilePixels> y;
  alignas(64) std::array<float, kTilePixels> z;
};

inline constexpr float kNoDepth_m = 3.0e38F;
inline constexpr std::int32_t kNoSolid = -1;
inline constexpr std::int32_t kGridSolid = -2;

struct TileHits {
  alignas(64) std::array<float, kTilePixels> depth_m;
  alignas(64) std::array<std::int32_t, kTilePixels> solid;  ///< place in the caster's list of prepared solids
};

/// Where `solid` is nearer than what `hits` holds, writes its depth and `place`. A ray that starts inside hits at 0.
void cast_tile(const PreparedSolid& solid, std::int32_t place, const TileRays& rays, TileHits& hits);

}  // namespace g3d::hal
