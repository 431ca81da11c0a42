// SPDX-License-Identifier: Apache-2.0
// Exact depth and colour images of a World: every solid is bounded on the image, tiles of 16x16 pixels test only the
// solids that can reach them, nearest first, and stop when the rest lies behind what they have.
// The images are the same to the last bit for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/row_workers.hpp"
#include "hal/sim/tile_kernels.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

/// What a perfect camera would see. Row-major, sized by the caster's camera model.
struct ExactView {
  explicit ExactView(const CameraModel& camera)
      : depth_m(camera.pixel_count()), surface(camera.pixel_count()), rgb(3 * camera.pixel_count()) {}

  static constexpr std::uint8_t kDark = 0x80;        ///< bit of `surface`: swallows the infrared
  static constexpr std::uint8_t kCosineMask = 0x7F;  ///< 127 * cosine between ray and surface normal

  std::vector<float> depth_m;         ///< along the optical axis; 0 where nothing is hit
  std::vector<std::uint8_t> surface;  ///< kDark | cosine
  std::vector<std::uint8_t> rgb;      ///< R G B
};

class RayCaster {
 public:
  /// `world` must outlive the caster. `threads` (1..64) counts the calling thread.
  RayCaster(const World& world, const CameraModel& camera, int threads);

  /// One thread at a time. Allocates nothing.
  void render(const Pose& T_world_camera, TimeNs time_ns, ExactView& out);
  /// The same with every mover where the caller says; the one numbered `hidden` (-1: none) is not drawn.
  void render(const Pose& T_world_camera, MoverPlaces places_m, std::int32_t hidden, ExactView& out);

  /// The threads, for work that follows on the same image.
  [[nodiscard]] RowWorkers& workers() { return workers_; }

 private:
  struct Tile {
    int column = 0;
    int row = 0;
    TileRays rays;
    TileHits hits;
    alignas(64) std::array<float, kTilePixels> inverse_length;  ///< 1 / |direction|
    std::array<std::uint8_t, kTilePixels> grid_axis;            ///< valid where the hit is kGridSolid
  };

  void prepare(const RigidTransform& T_world_camera, MoverPlaces places_m, std::int32_t hidden);
  void render_tile(int tile_column, int tile_row, const RigidTransform& T_world_camera, ExactView& out) const;
  void aim(Tile& tile, const RigidTransform& T_world_camera) const;
  void cast_opaque(Tile& tile) const;
  void cast_grid(Tile& tile, const std::array<float, 3>& camera_m) const;
  void shade(const Tile& tile, const std::array<float, 3>& camera_m, ExactView& out) const;
  void tint_behind(const PreparedSolid& pane, const Tile& tile, ExactView& out) const;
  /// visit(place in the tile, pixel index) for the tile's pixels within the image.
  template <typename Visit>
  void for_pixels(const Tile& tile, const Visit& visit) const;

  const World& world_;
  CameraModel camera_;
  int tile_columns_;
  int tile_rows_;
  std::vector<float> slope_x_;  ///< (u - cx) / fx, up to the border of the last tile
  std::vector<float> slope_y_;
  std::vector<PreparedSolid> opaque_;  ///< of the current image, nearest first
  std::vector<PreparedSolid> glass_;
  std::vector<std::array<float, 2>> places_m_;  ///< of the movers, where the clock says
  RowWorkers workers_;
};

}  // namespace g3d::hal
