// SPDX-License-Identifier: Apache-2.0
// The inner loops, compiled once per instruction set (the build passes the flags and names the namespace) and chosen at
// start. All variants give the same bits: float32 + - * / alone, no contraction, integers. Plain loops over arrays that
// the compiler turns into vectors; no intrinsics, so the same source serves amd64 and aarch64.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mapper/rgbo.hpp"

namespace g3d::mapper::cpu {

/// Counts of one image row by what its readings are.
struct RowCounts {
  std::uint32_t valid = 0;
  std::uint32_t too_near = 0;
  std::uint32_t far = 0;
  std::uint32_t invalid = 0;
};

inline constexpr std::uint8_t kHitFlag = 1;     ///< a measured point fell into the voxel
inline constexpr std::uint8_t kColourFlag = 2;  ///< and HitRecord::rgb is the colour of its lowest pixel
inline constexpr std::uint8_t kHeldFlag = 4;    ///< a reading too near to be trusted fell into it: no ray frees it
inline constexpr std::uint8_t kWeakFree = 1;    ///< seen through by a pixel without reading only
inline constexpr std::uint8_t kStrongFree = 3;  ///< seen through by a measured ray
inline constexpr std::uint32_t kNoBlock = 0xFFFFFFFFU;

struct ClassifyRow {
  const std::uint16_t* depth;  ///< this row
  const std::uint16_t* above;  ///< row above, or this row itself at the border
  const std::uint16_t* below;  ///< row below, or this row itself at the border
  int width;
  std::uint16_t near_raw;
  std::uint16_t far_raw;
  std::uint16_t* ends;        ///< out: raw depth up to which the pixel's ray carves; 0 = does not
  std::uint8_t* colour_flag;  ///< out: kColourFlag where the pixel may give its colour (no depth edge), else 0
  std::uint8_t* blind;        ///< out: 1 where there is no reading, else 0
};

/// Numbers of one row's back-projection. World point of pixel u: (c + column_slope[u] * r) * z + t, axis by axis.
struct UnprojectRow {
  const std::uint16_t* depth;
  const float* column_slope;
  int width;
  std::uint16_t near_raw;
  std::uint16_t far_raw;
  float metres_per_unit;
  float resolution_m;
  float column[3];    ///< R's first column
  float row_part[3];  ///< R's second column * row_slope + third column
  float translation[3];
  std::int32_t origin[3];
  std::int32_t nx_blocks;
  std::int32_t nxy_blocks;
  std::uint32_t* block_id;          ///< out: block in the frame's box, kNoBlock without a reading up to far_raw
  std::uint16_t* place;             ///< out: M & 511
  const std::uint8_t* colour_flag;  ///< from ClassifyRow
  std::uint32_t* code;              ///< out: block_id << 11 | place << 2 | too near << 1 | may give its colour
  std::uint8_t* starts;             ///< out: 1 at readings whose block or code is not that of the pixel before
};
/// Boxes with more blocks have voxels that share a code.
inline constexpr std::uint32_t kMostCodedBlocks = 1U << 21;

inline constexpr std::uint16_t kUnbounded = 0xFFFF;  ///< no reading bounds the invalid run on that side

/// One row of the upward pass over columns: pixels without a reading get their weak end.
struct BoundRow {
  const std::uint16_t* depth;
  const std::uint16_t* mask;  ///< free scan mask
  int count;
  std::uint16_t near_raw;
  std::uint16_t* last;  ///< last reading below, carried upwards
  std::uint16_t* ends;  ///< in: nearest reading beside or above, where there is none here; out: the weak end
};

/// Everything that is the same for all blocks of a frame in the projective test.
struct ProjectionTables {
  alignas(
      64) float x_px_m[512];  ///< fx times the offset along the camera's x of each place from the block's first voxel
  alignas(64) float y_px_m[512];
  alignas(64) float z_units[512];  ///< offset along the optical axis, in raw depth units
};

/// One brick of 64 voxels against one footprint image.
struct ProjectBrick {
  const ProjectionTables* tables;
  int first_place;  ///< 0, 64, ... 448
  float x_px_m;     ///< fx * camera x of the block's first voxel
  float y_px_m;
  float z_units;  ///< its depth, in raw units
  float metres_per_unit;
  float min_z_units;  ///< nearer voxels are never freed
  float bias_units;   ///< how far beyond the voxel's centre the ray must reach
  float scale;        ///< 1 / pixels per cell of the footprint image
  float shift_x;      ///< added to the scaled pixel coordinate: half a window, padding, principal point
  float shift_y;
  float first_x;  ///< smallest and largest start cell, as float: the window always meets the image
  float first_y;
  float last_x;
  float last_y;
  bool at_border;  ///< some voxels may lie outside of the image: test the four planes
  float left_px;   ///< pixel coordinates from the principal point to the centres of the outermost pixels
  float right_px;
  float top_px;
  float bottom_px;
  float reach_px_m[4];   ///< left, right, top, bottom: how far a voxel reaches across each plane, times f
  float far_units;       ///< where the rays of far readings end
  float far_bias_units;  ///< bias against these ends: they are no surface
  int stride;
  const std::uint16_t* image;
};

/// One brick of 64 voxels against the exact rays: which does the ray of the pixel at their middle pass for certain,
/// which can no ray reach?
struct SortBrick {
  const ProjectionTables* tables;
  int first_place;
  float x_px_m;  ///< as in ProjectBrick
  float y_px_m;
  float z_units;
  float metres_per_unit;
  float half_z_units;  ///< half a voxel's extent along the optical axis, and what rounding may change
  float sure_units;    ///< no deeper voxel passes for certain: it may lie between the pixels
  float middle_x;      ///< principal point, padding and half a pixel: the pixel of a coordinate is its integer part
  float middle_y;
  float first_px;  ///< first column and row, padding included
  float end_x;     ///< one past the last
  float end_y;
  const std::uint16_t* ends;  ///< padded
  int ends_stride;
  const std::uint16_t* farthest;  ///< image of maxima over windows that cover a voxel, or nullptr: too near for one
  int farthest_stride;
  float scale;  ///< for that image as in ProjectBrick
  float shift_x;
  float shift_y;
  float first_cell;  ///< smallest start cell along both axes
  float last_x;
  float last_y;
  float left_px;  ///< as in ProjectBrick
  float right_px;
  float top_px;
  float bottom_px;
  float reach_px_m[4];
};

inline constexpr std::uint8_t kPassed = 1;  ///< what sort_brick says of a voxel: a ray passes it for certain
inline constexpr std::uint8_t kOpen = 2;    ///< some ray may pass it; 0: none does

/// What is the same for all voxels of a frame when the rays through one of them are sought.
struct RaySearch {
  const std::uint16_t* ends;  ///< at pixel (0, 0); 64 more than the image may be read
  int ends_stride;
  std::uint16_t least_end;  ///< no ray ends nearer than here, none farther than there
  std::uint16_t most_end;
  const std::uint16_t* depth;  ///< readings, without padding
  int width_px;
  int height_px;
  const float* column_slope;  ///< 32 more than the image may be read
  const float* row_slope;
  float fx_px;
  float fy_px;
  float cx_px;
  float cy_px;
  float metres_per_unit;
  float resolution_m;
  float rotation[9];
  float translation[3];
  // What follows from these:
  float start[3];         ///< translation / resolution
  float most_coordinate;  ///< largest magnitude among them
  float cells_per_unit;   ///< voxels in a raw depth unit, and the reverse
  float units_per_cell;
  float half_z;                   ///< half extent of a voxel along the optical axis, in voxels
  alignas(32) float corner_x[8];  ///< a voxel's corners from its centre along the camera's axes, in voxels
  alignas(32) float corner_y[8];
  alignas(32) float corner_z[8];
};

struct ApplyBlock {
  std::uint8_t* levels;      ///< 512 stored bytes, updated in place
  const std::uint8_t* hits;  ///< 512 flags, or nullptr: no hit in this block
  const std::uint8_t* free;  ///< 512 flags, or nullptr: nothing free
  UpdateSteps steps;
};

struct ApplyResult {
  bool changed;
  bool all_equal;            ///< afterwards all 512 bytes are the same
  std::uint8_t lost_colour;  ///< bit b: a voxel of brick b lost its colour
};

inline constexpr int kRayLanes = 32;

/// Up to 32 neighbouring pixels of one row whose rays walk the frame's byte grid in lockstep.
struct RayRow {
  const std::uint16_t* ends;   ///< raw depth of each ray's end; 0 = no ray
  const std::uint16_t* depth;  ///< the readings: 0 marks a weak ray
  int lanes;                   ///< 1..32
  bool strong;                 ///< walk the rays of readings, or those of pixels without one
  const float* column_slope;   ///< (u - cx) / fx; 32 may be read
  float metres_per_unit;
  float resolution_m;
  float column[3];  ///< as in UnprojectRow
  float row_part[3];
  float translation[3];
  std::int32_t origin[3];  ///< lowest voxel of the grid
  std::int32_t stride[3];  ///< cells of the byte grid from one voxel to the next along each axis
  std::uint8_t* grid;
  std::int32_t spare_cell;  ///< lanes that are done write here
};

inline constexpr int kMostBoxes = 64;

/// What is the same for all cubes of one size in a frame.
struct BoxView {
  float half_x_m;  ///< half extents of the cube along the camera's axes
  float half_y_m;
  float half_z_m;
  float fx_px;
  float fy_px;
  float cx_px;
  float cy_px;
  float last_u_px;
  float last_v_px;
  float near_plane_m;  ///< nearer cubes are not projected: they may cover the whole image
  float far_m;
  float window_px_m;  ///< a voxel at depth z is looked up in a window of about window_px_m / z pixels
  // A plane through the camera and the image's left, right, upper or lower border has the normal (f, -border); centre
  // times normal below -outer_px_m: wholly outside; at least inner_px_m: each of its voxels reaches into the image.
  float left_px;  ///< the borders, counted from the principal point
  float right_px;
  float top_px;
  float bottom_px;
  float outer_px_m[4];
  float inner_px_m[4];
};

/// Camera-frame centres of up to 64 cubes, and what their projections cover.
struct BoxBounds {
  alignas(64) float x_m[kMostBoxes];
  alignas(64) float y_m[kMostBoxes];
  alignas(64) float z_m[kMostBoxes];
  alignas(64) std::int32_t u0[kMostBoxes];  ///< columns and rows that any window of the cube's voxels touches
  alignas(64) std::int32_t v0[kMostBoxes];
  alignas(64) std::int32_t u1[kMostBoxes];
  alignas(64) std::int32_t v1[kMostBoxes];
  alignas(64) std::int32_t centre_u0[kMostBoxes];  ///< columns and rows of its voxels' centres alone, where `inside`
  alignas(64) std::int32_t centre_v0[kMostBoxes];
  alignas(64) std::int32_t centre_u1[kMostBoxes];
  alignas(64) std::int32_t centre_v1[kMostBoxes];
  alignas(64) std::int32_t hidden[kMostBoxes];  ///< 1: outside of the frustum
  alignas(64) std::int32_t inside[kMostBoxes];  ///< 1: wholly within the image
  alignas(64) std::int32_t clear[kMostBoxes];   ///< 1: no voxel has to be tested against the image's border
};

struct Kernels {
  const char* name;
  RowCounts (*classify_row)(const ClassifyRow&);
  /// Where there is no reading: ends = min(ends, last). Where there is one: last = it.
  void (*carry_down)(const std::uint16_t* depth, int count, std::uint16_t* last, std::uint16_t* ends);
  void (*bound_up)(const BoundRow&);
  void (*unproject_row)(const UnprojectRow&);
  /// Clears starts[u] where one of the three pixels above has the same code: it has said it all.
  void (*drop_repeats)(const std::uint32_t* code, const std::uint32_t* code_above, int width, std::uint8_t* starts);
  /// out[x] = max(a[x], a[x + shift], b[x], b[x + shift]) for x in [0, count).
  void (*max_filter_row)(const std::uint16_t* a, const std::uint16_t* b, int shift, int count, std::uint16_t* out);
  /// Halves two rows: out[x] = max (min) over a[2x], a[2x+1], b[2x], b[2x+1].
  void (*halve_max_row)(const std::uint16_t* a, const std::uint16_t* b, int count, std::uint16_t* out);
  void (*halve_min_row)(const std::uint16_t* a, const std::uint16_t* b, int count, std::uint16_t* out);
  void (*bound_boxes)(const BoxView&, int count, BoxBounds&);
  /// Sets free[first_place .. +64) to kWeakFree or 0; returns whether any was set.
  bool (*project_brick)(const ProjectBrick&, std::uint8_t* free);
  ApplyResult (*apply_block)(const ApplyBlock&);
  /// Is any occupied voxel without a hit marked kWeakFree?
  bool (*any_contested)(const std::uint8_t* levels, const std::uint8_t* hits, const std::uint8_t* free);
  /// Says of 64 voxels what is certain; returns whether any may be passed.
  bool (*sort_brick)(const SortBrick&, std::uint8_t* sorted);
  /// Does an exact ray (of a measured pixel, if `strong`) pass the voxel (x, y, z) before its last one?
  bool (*find_ray)(const RaySearch&, const std::int32_t* voxel, bool strong);
  void (*walk_rays)(const RayRow&);
  void (*walk_bresenham)(const RayRow&);
};

/// The best variant that this processor runs. `name` may ask for one: "baseline", "avx2", "avx512"; unknown or
/// unsupported names give the baseline.
[[nodiscard]] const Kernels& best_kernels();
[[nodiscard]] const Kernels& kernels_by_name(const char* name);

}  // namespace g3d::mapper::cpu
