// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/ray_caster.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/sim/shading.hpp"

namespace g3d::hal {
namespace {

// By how much beams are widened before a solid is excluded: far more than float rounding, far less than a pixel.
constexpr float kBeamMargin = 1e-4F;

using Corners = std::array<std::array<float, 3>, 8>;

/// Corners of the solid's bounding box in the camera frame.
Corners corners_in_camera(const Primitive& solid, const RigidTransform& T_world_camera) {
  Corners corners;
  for (std::size_t n = 0; n < 8; ++n) {
    const float x = (n & 1) != 0 ? solid.half_m[0] : -solid.half_m[0];
    const float y = (n & 2) != 0 ? solid.half_m[1] : -solid.half_m[1];
    const float z = (n & 4) != 0 ? solid.half_m[2] : -solid.half_m[2];
    const std::array<float, 3> p = {
        solid.centre_m[0] + solid.cos_yaw * x - solid.sin_yaw * y - T_world_camera.translation_m[0],
        solid.centre_m[1] + solid.sin_yaw * x + solid.cos_yaw * y - T_world_camera.translation_m[1],
        solid.centre_m[2] + z - T_world_camera.translation_m[2]};
    const auto& r = T_world_camera.rotation;
    for (std::size_t k = 0; k < 3; ++k) corners[n][k] = r[k] * p[0] + r[3 + k] * p[1] + r[6 + k] * p[2];
  }
  return corners;
}

/// First and last tile along one image axis whose beam the corners may reach; false if none.
bool bound_tiles(const Corners& corners, std::size_t axis, const std::vector<float>& slopes, int tiles,
                 std::int32_t& low, std::int32_t& high) {
  low = tiles;
  high = -1;
  for (int tile = 0; tile < tiles; ++tile) {
    const float from = slopes[static_cast<std::size_t>(tile) * kTileSide_px] - kBeamMargin;
    const float to = slopes[static_cast<std::size_t>(tile) * kTileSide_px + kTileSide_px - 1] + kBeamMargin;
    bool all_before = true;
    bool all_after = true;
    for (const auto& c : corners) {
      all_before = all_before && c[axis] < from * c[2];
      all_after = all_after && c[axis] > to * c[2];
    }
    if (all_before || all_after) continue;
    low = std::min(low, tile);
    high = tile;
  }
  return high >= 0;
}

PreparedSolid as_seen_from(const Primitive& solid, std::size_t index, const std::array<float, 3>& camera_m) {
  PreparedSolid s;
  s.shape = solid.shape;
  const float x = camera_m[0] - solid.centre_m[0];
  const float y = camera_m[1] - solid.centre_m[1];
  s.origin = {solid.cos_yaw * x + solid.sin_yaw * y, solid.cos_yaw * y - solid.sin_yaw * x,
              camera_m[2] - solid.centre_m[2]};
  s.half = solid.half_m;
  s.cos_yaw = solid.cos_yaw;
  s.sin_yaw = solid.sin_yaw;
  s.radius = solid.radius_low_m;
  if (solid.shape == Shape::cone) {
    s.radius = 0.5F * (solid.radius_low_m + solid.radius_high_m);
    s.slope = (solid.radius_high_m - solid.radius_low_m) / (2.0F * solid.half_m[2]);
  }
  s.index = static_cast<std::int32_t>(index);
  return s;
}

bool is_reached(const PreparedSolid& s, int tile_column, int tile_row) {
  return s.tile_low[0] <= tile_column && tile_column <= s.tile_high[0] && s.tile_low[1] <= tile_row &&
         tile_row <= s.tile_high[1];
}

std::vector<float> slopes(int tiles, float centre_px, float focal_px) {
  std::vector<float> out(static_cast<std::size_t>(tiles) * kTileSide_px);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (static_cast<float>(i) - centre_px) / focal_px;
  return out;
}

float largest(const std::array<float, kTilePixels>& values) {
  // Eight maxima side by side, so that it becomes vector code.
  std::array<float, 8> best;
  std::copy_n(values.begin(), 8, best.begin());
  for (std::size_t i = 8; i < kTilePixels; i += 8) {
    for (std::size_t k = 0; k < 8; ++k) best[k] = best[k] > values[i + k] ? best[k] : values[i + k];
  }
  return *std::max_element(best.begin(), best.end());
}

int tiles_for(int pixels) { return (pixels + kTileSide_px - 1) / kTileSide_px; }

}  // namespace

RayCaster::RayCaster(const World& world, const CameraModel& camera, int threads)
    : world_(world),
      camera_(camera),
      tile_columns_(tiles_for(camera.width_px)),
      tile_rows_(tiles_for(camera.height_px)),
      slope_x_(slopes(tile_columns_, camera.cx_px, camera.fx_px)),
      slope_y_(slopes(tile_rows_, camera.cy_px, camera.fy_px)),
      workers_(threads) {
  opaque_.reserve(world.primitives().size());
  glass_.reserve(world.primitives().size());
  places_m_.resize(world.movers().size());
}

void RayCaster::render(const Pose& T_world_camera, TimeNs time_ns, ExactView& out) {
  for (std::size_t i = 0; i < places_m_.size(); ++i) places_m_[i] = world_.mover_at(i, time_ns);
  render(T_world_camera, places_m_, -1, out);
}

void RayCaster::render(const Pose& T_world_camera, MoverPlaces places_m, std::int32_t hidden, ExactView& out) {
  const RigidTransform transform = to_transform(T_world_camera);
  prepare(transform, places_m, hidden);
  workers_.run(tile_rows_, [&](int tile_row) {
    for (int column = 0; column < tile_columns_; ++column) render_tile(column, tile_row, transform, out);
  });
}

void RayCaster::prepare(const RigidTransform& T_world_camera, MoverPlaces places_m, std::int32_t hidden) {
  opaque_.clear();
  glass_.clear();
  for (std::size_t i = 0; i < world_.primitives().size(); ++i) {
    const Primitive solid = world_.placed(i, places_m);
    if (solid.mover >= 0 && solid.mover == hidden) continue;
    const Corners corners = corners_in_camera(solid, T_world_camera);
    float nearest_m = kNoDepth_m;
    float farthest_m = -kNoDepth_m;
    for (const auto& c : corners) {
      nearest_m = std::min(nearest_m, c[2]);
      farthest_m = std::max(farthest_m, c[2]);
    }
    if (farthest_m < 0.0F) continue;
    PreparedSolid s = as_seen_from(solid, i, T_world_camera.translation_m);
    s.nearest_m = nearest_m - kBeamMargin * (1.0F + std::abs(nearest_m));
    if (!bound_tiles(corners, 0, slope_x_, tile_columns_, s.tile_low[0], s.tile_high[0])) continue;
    if (!bound_tiles(corners, 1, slope_y_, tile_rows_, s.tile_low[1], s.tile_high[1])) continue;
    (solid.material.glass ? glass_ : opaque_).push_back(s);
  }
  // The index breaks ties, so that equal depths go to the same solid whatever the sorting does.
  std::sort(opaque_.begin(), opaque_.end(), [](const PreparedSolid& a, const PreparedSolid& b) {
    return a.nearest_m != b.nearest_m ? a.nearest_m < b.nearest_m : a.index < b.index;
  });
}

void RayCaster::render_tile(int tile_column, int tile_row, const RigidTransform& T_world_camera, ExactView& out) const {
  Tile tile;
  tile.column = tile_column;
  tile.row = tile_row;
  aim(tile, T_world_camera);
  cast_opaque(tile);
  if (world_.grid()) cast_grid(tile, T_world_camera.translation_m);
  shade(tile, T_world_camera.translation_m, out);
  for (const PreparedSolid& pane : glass_) {
    if (is_reached(pane, tile_column, tile_row)) tint_behind(pane, tile, out);
  }
}

void RayCaster::aim(Tile& tile, const RigidTransform& T_world_camera) const {
  const auto& r = T_world_camera.rotation;
  const float* slope_x = &slope_x_[static_cast<std::size_t>(tile.column) * kTileSide_px];
  const float* slope_y = &slope_y_[static_cast<std::size_t>(tile.row) * kTileSide_px];
  for (std::size_t j = 0; j < kTileSide_px; ++j) {
    const float y = slope_y[j];
    for (std::size_t i = 0; i < kTileSide_px; ++i) {
      const float x = slope_x[i];
      const std::size_t n = j * kTileSide_px + i;
      tile.rays.x[n] = r[0] * x + r[1] * y + r[2];
      tile.rays.y[n] = r[3] * x + r[4] * y + r[5];
      tile.rays.z[n] = r[6] * x + r[7] * y + r[8];
      tile.inverse_length[n] = 1.0F / std::sqrt(x * x + y * y + 1.0F);
    }
  }
}

void RayCaster::cast_opaque(Tile& tile) const {
  tile.hits.depth_m.fill(kNoDepth_m);
  tile.hits.solid.fill(kNoSolid);
  float farthest_m = kNoDepth_m;
  for (std::size_t place = 0; place < opaque_.size(); ++place) {
    const PreparedSolid& solid = opaque_[place];
    if (solid.nearest_m >= farthest_m) return;
    if (!is_reached(solid, tile.column, tile.row)) continue;
    cast_tile(solid, static_cast<std::int32_t>(place), tile.rays, tile.hits);
    farthest_m = largest(tile.hits.depth_m);
  }
}

void RayCaster::cast_grid(Tile& tile, const std::array<float, 3>& camera_m) const {
  const GridWalls& grid = *world_.grid();
  const bool is_between = camera_m[2] > grid.z_low_m() && camera_m[2] < grid.z_high_m();
  const auto note = [&tile](std::size_t n, const GridWalls::Hit& hit) {
    tile.hits.depth_m[n] = hit.t;
    tile.hits.solid[n] = kGridSolid;
    tile.grid_axis[n] = static_cast<std::uint8_t>(hit.axis);
  };
  for (std::size_t i = 0; i < kTileSide_px; ++i) {
    // Where the camera is level, all rays of a column run above one line on the floor and meet the same wall.
    bool is_level = is_between;
    float farthest_m = 0.0F;
    for (std::size_t n = i; n < kTilePixels; n += kTileSide_px) {
      is_level = is_level && tile.rays.x[n] == tile.rays.x[i] && tile.rays.y[n] == tile.rays.y[i];
      farthest_m = std::max(farthest_m, tile.hits.depth_m[n]);
    }
    GridWalls::Hit shared{};
    if (is_level) shared = grid.cast(camera_m, {tile.rays.x[i], tile.rays.y[i], 0.0F}, farthest_m);
    for (std::size_t n = i; n < kTilePixels; n += kTileSide_px) {
      if (is_level) {
        if (shared.t < tile.hits.depth_m[n] && shared.t < grid.leaves_walls_at(camera_m[2], tile.rays.z[n])) {
          note(n, shared);
        }
        continue;
      }
      const GridWalls::Hit hit =
          grid.cast(camera_m, {tile.rays.x[n], tile.rays.y[n], tile.rays.z[n]}, tile.hits.depth_m[n]);
      if (hit.t < tile.hits.depth_m[n]) note(n, hit);
    }
  }
}

template <typename Visit>
void RayCaster::for_pixels(const Tile& tile, const Visit& visit) const {
  const int first_u = tile.column * kTileSide_px;
  const int first_v = tile.row * kTileSide_px;
  const int columns = std::min(kTileSide_px, camera_.width_px - first_u);
  const int rows = std::min(kTileSide_px, camera_.height_px - first_v);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      visit(static_cast<std::size_t>(j) * kTileSide_px + static_cast<std::size_t>(i),
            static_cast<std::size_t>(first_v + j) * static_cast<std::size_t>(camera_.width_px) +
                static_cast<std::size_t>(first_u + i));
    }
  }
}

void RayCaster::shade(const Tile& tile, const std::array<float, 3>& camera_m, ExactView& out) const {
  for_pixels(tile, [&](std::size_t n, std::size_t pixel) {
    const std::array<float, 3> direction = {tile.rays.x[n], tile.rays.y[n], tile.rays.z[n]};
    const float depth_m = tile.hits.depth_m[n];
    const std::int32_t place = tile.hits.solid[n];
    Shade seen;
    bool dark = false;
    if (place >= 0) {
      const PreparedSolid& solid = opaque_[static_cast<std::size_t>(place)];
      const Material& material = world_.primitives()[static_cast<std::size_t>(solid.index)].material;
      seen = shade_solid(solid, material, direction, depth_m, tile.inverse_length[n]);
      dark = material.dark;
    } else if (place == kGridSolid) {
      seen = shade_grid(*world_.grid(), tile.grid_axis[n], camera_m, direction, depth_m, tile.inverse_length[n]);
    } else {
      seen.colour = shade_sky(direction, tile.inverse_length[n]);
    }
    out.depth_m[pixel] = place == kNoSolid ? 0.0F : depth_m;
    const auto cosine = static_cast<std::uint8_t>(seen.cos_incidence * ExactView::kCosineMask);
    out.surface[pixel] = dark ? cosine | ExactView::kDark : cosine;
    out.rgb[3 * pixel] = seen.colour.r;
    out.rgb[3 * pixel + 1] = seen.colour.g;
    out.rgb[3 * pixel + 2] = seen.colour.b;
  });
}

void RayCaster::tint_behind(const PreparedSolid& pane, const Tile& tile, ExactView& out) const {
  TileHits in_front = tile.hits;
  in_front.solid.fill(kNoSolid);
  cast_tile(pane, 0, tile.rays, in_front);
  const Rgb colour = world_.primitives()[static_cast<std::size_t>(pane.index)].material.colour;
  for_pixels(tile, [&](std::size_t n, std::size_t pixel) {
    if (in_front.solid[n] == kNoSolid) return;
    std::uint8_t* rgb = &out.rgb[3 * pixel];
    const Rgb mixed = tint({rgb[0], rgb[1], rgb[2]}, colour);
    rgb[0] = mixed.r;
    rgb[1] = mixed.g;
    rgb[2] = mixed.b;
  });
}

}  // namespace g3d::hal
