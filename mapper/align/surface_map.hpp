// SPDX-License-Identifier: Apache-2.0
// The surfaces of a map as small flat pieces, fine enough to align frames to: a voxel says where a surface is to within
// its edge, but the mean of a hundred readings in a cell says so to within a millimetre.
//
// One piece per cell and per way that it faces (the dominant axis of its normal, with sign), so that the two sides of a
// thin wall and the two walls of a corner stay apart. Sums are integers, so the order of the samples does not matter.
// All memory is reserved at construction; a full table takes no new pieces and counts them. Thread: one.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "hal/messages.hpp"
#include "mapper/align/depth_samples.hpp"
#include "mapper/align/seen_space.hpp"
#include "mapper/pool.hpp"

namespace g3d::mapper::align {

/// Where a surface passes: the plane through `point_m` across `normal`.
struct SurfacePiece {
  Vector3f point_m;
  Vector3f normal;  ///< unit, towards free space
};

struct SurfaceOptions {
  float cell_m = 0.08F;
  std::size_t slots = std::size_t{1} << 20;  ///< a power of two; 48 bytes each. Three quarters can be used
  float least_sample_weight =
      0.0008F;                   ///< samples below are matched, but not added: they would fill cells beside the surface
  float least_coherence = 0.9F;  ///< length of a cell's mean normal; below, it holds a corner or a ball
};

class SurfaceMap {
 public:
  explicit SurfaceMap(const SurfaceOptions& options = {});

  /// Adds samples of one frame. With a map, which does not hold this frame yet: what has come into free space is
  /// kept, but never found again.
  void add(std::span<const DepthSample> samples, const hal::RigidTransform& T_world_camera, hal::TimeNs stamp_ns = 0,
           const SeenSpace* space = nullptr);
  /// Looks at the next part of all pieces, kSweeps-th of the table; those around which everything is free by now have
  /// left, and are not found again.
  void forget_gone(const SeenSpace& space);
  static constexpr std::size_t kSweeps = 32;
  void clear();
  /// Every piece goes where the correction of the time of its birth takes it. Those that came into free space or have
  /// left are forgotten: they would be found out again. Allocates.
  void move(const std::function<hal::Pose(hal::TimeNs)>& correction_at);
  /// The piece nearest to a point in the cell of the point and in those before and behind it, facing like `normal`, and
  /// first seen at `born_by_ns` at the latest: what moves is nowhere for long.
  [[nodiscard]] std::optional<SurfacePiece> find(const Vector3f& point_m, const Vector3f& normal,
                                                 hal::TimeNs born_by_ns = kAnyTime) const;
  static constexpr hal::TimeNs kAnyTime = std::numeric_limits<hal::TimeNs>::max() - 1;

  [[nodiscard]] std::size_t piece_count() const { return count_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }
  /// Pieces that came into free space, or have left.
  [[nodiscard]] std::size_t unsteady_count() const { return unsteady_; }
  [[nodiscard]] const SurfaceOptions& options() const { return options_; }

  /// Calls `visit(const SurfacePiece&, float weight)` for every piece that is sure enough, in no order that matters.
  template <typename Visit>
  void for_each(Visit visit) const {
    for (std::size_t i = 0; i < table_.size(); ++i) {
      if (table_[i].key == 0 || table_[i].born_ns == kUnsteady) continue;
      if (const auto piece = piece_of(table_[i])) visit(*piece, static_cast<float>(table_[i].weight));
    }
  }

 private:
  static constexpr hal::TimeNs kUnsteady = std::numeric_limits<hal::TimeNs>::max();  ///< instead of a time of birth

  struct Cell {
    std::uint64_t key = 0;    ///< 0: nothing here
    std::uint32_t frame = 0;  ///< the last one that added to it
    std::int32_t weight = 0;
    hal::TimeNs born_ns = 0;
    std::int32_t place[3] = {};   ///< sums of weight * offset from the cell's low corner, in 1/1024 of a cell
    std::int32_t normal[3] = {};  ///< sums of weight * normal * 1024
  };

  static void halve(Cell& cell);
  /// A point in cells, and the low corner of the one it lies in. Nothing beyond the keys' room.
  struct Place {
    float q[3];
    float low[3];
  };
  [[nodiscard]] std::optional<Place> place_of(const Vector3f& point_m) const;
  [[nodiscard]] static std::uint64_t key_at(const Place& place, const Vector3f& normal);
  /// The cell of a key, or the empty one where it belongs.
  [[nodiscard]] Cell& cell_for(std::uint64_t key);
  static void add_to(Cell& cell, const Place& place, const Vector3f& normal, std::int32_t weight);
  [[nodiscard]] static Vector3f mean_normal(const Cell& cell);
  [[nodiscard]] Vector3f mean_point_m(const Cell& cell) const;
  [[nodiscard]] const Cell* look_up(std::uint64_t key) const;
  [[nodiscard]] std::optional<SurfacePiece> piece_of(const Cell& cell) const;

  SurfaceOptions options_;
  std::size_t mask_;
  ReservedArray<Cell> table_;
  std::size_t count_ = 0;
  std::uint32_t frame_ = 0;
  std::uint64_t refused_ = 0;
  std::size_t unsteady_ = 0;
  std::size_t next_swept_ = 0;
};

}  // namespace g3d::mapper::align
