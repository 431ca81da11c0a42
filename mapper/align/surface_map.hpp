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
#include "mapper/align/surface_cell.hpp"
#include "mapper/pool.hpp"

namespace g3d::mapper::align {

struct SurfaceOptions {
  SurfaceRule rule{};
  std::size_t slots = std::size_t{1} << 20;  ///< a power of two; 48 bytes each. Three quarters can be used
};

class SurfaceMap {
 public:
  explicit SurfaceMap(const SurfaceOptions& options = {});

  /// Adds samples of one frame. With a map, which does not hold this frame yet: what has come into free space is
  /// kept, but never found again.
  void add(std::span<const DepthSample> samples, const hal::RigidTransform& T_world_camera, hal::TimeNs stamp_ns = 0,
           const SeenSpace* space = nullptr);
  /// Looks at the next part of all pieces: those whose keys' homes are in the next kSweeps-th of the table. Around
  /// which everything is free by now, those have left, and are not found again.
  void forget_gone(const SeenSpace& space);
  static constexpr std::size_t kSweeps = 32;
  /// A frame adds cells if the table was less than three quarters full before it: whoever comes first among its
  /// samples.
  [[nodiscard]] bool takes_new_cells() const { return count_ * 4 < table_.size() * 3; }
  /// Once the table is three fifths full: forgets what is no piece (yet) or a poor one and has not been seen lately; if
  /// that is not enough also what has not been seen for longest, down to two fifths. Which cells go does not depend on
  /// where in the table they lie. A pass over the whole table, then none for long. Returns how many.
  std::size_t make_room();
  void clear();
  /// Every piece goes where the correction of the time of its birth takes it. Those that came into free space or have
  /// left are forgotten: they would be found out again. Allocates.
  void move(const std::function<hal::Pose(hal::TimeNs)>& correction_at);
  /// The piece nearest to a point in the cell of the point and in those before and behind it, facing like `normal`, and
  /// first seen at `born_by_ns` at the latest: what moves is nowhere for long.
  [[nodiscard]] std::optional<SurfacePiece> find(const Vector3f& point_m, const Vector3f& normal,
                                                 hal::TimeNs born_by_ns = kAnyTime) const;
  /// nullptr: there is none.
  [[nodiscard]] const SurfaceCell* look_up(std::uint64_t key) const;
  static constexpr hal::TimeNs kAnyTime = std::numeric_limits<hal::TimeNs>::max() - 1;

  // For whoever keeps a copy elsewhere, and computes there what add() and forget_gone() would: this is its mirror then.
  [[nodiscard]] std::uint32_t next_frame() const { return frame_ + 1; }
  struct Homes {
    std::size_t first, end;
  };
  [[nodiscard]] Homes next_swept() const { return {next_swept_, next_swept_ + table_.size() / kSweeps}; }
  [[nodiscard]] std::span<const SurfaceCell> table() const { return {table_.data(), table_.size()}; }
  /// The cells that one frame has changed, each once. False: no add() can have left these, and nothing was taken.
  [[nodiscard]] bool take(std::span<const SurfaceCell> changed, std::uint64_t refused, bool was_swept);

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
      SurfacePiece piece;
      if (piece_of(options_.rule, table_[i], piece)) visit(piece, static_cast<float>(table_[i].weight));
    }
  }

 private:
  /// The cell of a key, or the empty one where it belongs.
  [[nodiscard]] SurfaceCell& cell_for(std::uint64_t key);
  static void add_to(SurfaceCell& cell, const CellPlace& place, const Vector3f& normal, std::int32_t weight);
  [[nodiscard]] bool is_poor(const SurfaceCell& cell) const;
  void erase(std::size_t slot);
  void forget_if_gone(SurfaceCell& cell, const SeenSpace& space);

  SurfaceOptions options_;
  std::size_t mask_;
  ReservedArray<SurfaceCell> table_;
  std::size_t count_ = 0;
  std::uint32_t frame_ = 0;
  std::uint64_t refused_ = 0;
  std::size_t unsteady_ = 0;
  std::size_t next_swept_ = 0;
};

}  // namespace g3d::mapper::align
