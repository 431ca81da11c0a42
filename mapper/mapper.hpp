// SPDX-License-Identifier: Apache-2.0
// Posed frame in, changed blocks out: the one interface behind which the integrators and both twins stand.
// Thread: all calls from the mapper thread. After construction integrate() allocates nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/messages.hpp"
#include "mapper/column_bits.hpp"
#include "mapper/look.hpp"
#include "mapper/rgbo.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

namespace cuda {
struct ChangedClasses;
}

enum class IntegratorKind : std::uint8_t { dda, bresenham, projective };
enum class MapMode : std::uint8_t {
  static_mode,   ///< registers only occupied voxels
  dynamic_mode,  ///< occupied, free, and (by absence) unknown
};
/// Where maps are computed. All give the same map.
enum class Backend : std::uint8_t {
  cpu,
  cuda,       ///< an NVIDIA card; while there is none, the CPU
  automatic,  ///< the same, but nobody insists
};
[[nodiscard]] const char* to_string(IntegratorKind kind);
[[nodiscard]] const char* to_string(MapMode mode);
[[nodiscard]] std::optional<IntegratorKind> integrator_from_string(std::string_view name);
[[nodiscard]] std::optional<MapMode> mode_from_string(std::string_view name);

struct MapperConfig {
  float resolution_m = 0.05F;  ///< 0.002..1
  IntegratorKind integrator = IntegratorKind::projective;
  MapMode mode = MapMode::dynamic_mode;
  UpdateSteps steps;
  float near_m = 0.8F;  ///< certainty bounds: depth z of a trusted reading
  float far_m = 3.5F;
  float mask_depth_m = 3.0F;  ///< free scan mask made from the intrinsics, when none was recorded
  bool carve_invalid = true;  ///< false: pixels without a reading carve nothing
  bool with_colour = true;
  int threads = 1;  ///< 1..64, the calling thread included
  MapCapacity capacity;
  Backend backend = Backend::cpu;
  std::uint32_t surface_slots = 0;             ///< of the aligner's table, if a card is to align as well
  std::int64_t card_patience_ns = 33'000'000;  ///< a card that takes longer for a frame is taken for hung
};

/// What became of the card.
struct CardReport {
  bool in_use = false;  ///< the last frame was integrated there
  std::string name;     ///< empty: there never was one
  std::string problem;  ///< why not, or why it was lost; empty: nothing went wrong
  std::uint64_t memory_bytes = 0;
  std::uint64_t frames_on_card = 0;
  std::uint64_t frames_on_cpu = 0;      ///< since there was to be a card
  std::uint64_t questions_on_card = 0;  ///< batches of rays or looks
  std::uint64_t questions_on_cpu = 0;
  std::uint64_t fits_on_card = 0;  ///< frames that were aligned
  std::uint64_t fits_on_cpu = 0;
  std::uint32_t losses = 0;  ///< times that its helper died, hung or failed; the CPU took over in that very frame
};

/// Why a Mapper cannot be built for this camera: a sentence with the remedy. Call it before the constructor with what
/// comes from outside; the constructor itself only asserts.
[[nodiscard]] std::optional<std::string> config_problem(const MapperConfig& config, const hal::CameraModel& camera);

enum class FrameStatus : std::uint8_t {
  integrated,
  pool_full,     ///< integrated as far as memory allowed; see FrameReport::refused_blocks
  out_of_range,  ///< the camera stands outside of the 16-bit grid: nothing was changed
};

struct FrameReport {
  FrameStatus status = FrameStatus::integrated;
  std::uint32_t valid_pixels = 0;     ///< readings within the certainty bounds
  std::uint32_t too_near_pixels = 0;  ///< readings nearer than near_m: for navigation
  std::uint32_t far_pixels = 0;
  std::uint32_t invalid_pixels = 0;
  std::uint32_t hit_blocks = 0;  ///< blocks of 8x8x8 voxels in which something was measured
  std::uint32_t refused_blocks = 0;
};

namespace align {
class FitCard;
}

class Mapper {
 public:
  /// `scan_mask`: width * height raw depths up to which a pixel without reading may carve; empty = from the intrinsics.
  Mapper(const MapperConfig& config, const hal::CameraModel& camera, std::span<const std::uint16_t> scan_mask = {});
  ~Mapper();
  Mapper(const Mapper&) = delete;
  Mapper& operator=(const Mapper&) = delete;

  /// One frame changes a voxel at most once. The frame's images have the size of `camera`.
  FrameReport integrate(const hal::Frame& frame, const hal::Pose& T_world_camera) {
    (void)begin_frame(frame, T_world_camera);
    return finish_frame();
  }
  /// The first part of integrate(). True: a card has integrated the frame, and card_classes() tells what it changed,
  /// while map() is still the frame before. The frame must stay until finish_frame() has brought map() up to date.
  bool begin_frame(const hal::Frame& frame, const hal::Pose& T_world_camera);
  FrameReport finish_frame();
  /// After begin_frame() returned true. Empty if they were too many to be sent at once.
  [[nodiscard]] cuda::ChangedClasses card_classes() const;

  /// From now on a card also tells after begin_frame() what the changed blocks say about the floor below them, so that
  /// nobody has to look at their voxels.
  void follow_columns(const ColumnTables& tables);
  /// After begin_frame() returned true, until the next one. Without an answer look at the map instead.
  [[nodiscard]] ChangedColumns card_columns() const;

  /// Takes the robot's own footprint as free: a vertical cylinder standing on `base`. For the start, before any frame.
  void free_footprint(const std::array<double, 3>& base_m, double radius_m, double height_m);

  // Questions in bulk about map(), answered by the card if it has one, else by all threads of the mapper. Both give the
  // same answers. Nothing is allocated.
  /// One hit per ray. See cast_ray() for a single one.
  void cast_rays(std::span<const BulkRay> rays, std::span<BulkHit> hits);
  /// A look of the mapper's camera from a pose; one ray for `stride_px` columns and rows.
  [[nodiscard]] Look look_from(const hal::Pose& T_world_camera) const;
  /// Fills in the gains: what each look would newly show. They are zero before.
  void count_looks(std::span<Look> looks, int stride_px);
  /// What the camera is expected to measure from there: rays for cast_rays(), row by row, at most rays.size(). The
  /// depth of a hit is distance_m / |direction|. Returns how many.
  std::size_t rays_from(const hal::Pose& T_world_camera, int stride_px, std::span<BulkRay> rays) const;

  /// Slots of the blocks that the last integrate() changed, each once. Valid until the next call.
  [[nodiscard]] std::span<const std::uint32_t> changed_slots() const;

  /// Aligns frames for an aligner in the mapper's thread, before they are integrated. nullptr: there is no card, or the
  /// configuration has no surface_slots.
  [[nodiscard]] align::FitCard* fit_card();

  /// "cuda" if the last frame was integrated by a card (before the first one: would be), else "cpu".
  [[nodiscard]] const char* backend_name() const;
  [[nodiscard]] CardReport card() const;
  /// The process that owns the card, -1 if there is none. For tests.
  [[nodiscard]] int card_process() const;

  [[nodiscard]] VoxelMap& map();
  [[nodiscard]] const VoxelMap& map() const;
  [[nodiscard]] const MapperConfig& config() const;
  /// CPU time of the mapper's own threads so far, without the caller's. Any thread.
  [[nodiscard]] std::int64_t workers_cpu_ns() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace g3d::mapper
