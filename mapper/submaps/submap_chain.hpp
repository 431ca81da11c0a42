// SPDX-License-Identifier: Apache-2.0
// The map as a chain of submaps, each with a pose of its own: a pose that is corrected later moves its voxels without
// touching them.
//
// Frames go into one map, the view, as if there were no submaps. When the robot has gone some metres, what has changed
// since is kept as a submap: the voxels whose codes are not what the submaps before say. So the newest submap that
// knows a voxel says what it is, and as long as no pose is corrected the chain is the view, to the bit. After a
// correction rebuild() makes the view anew. With a shelf, what is far lies on disk. Thread: the one that maps; what a
// StretchRecorder has taken may be added from another one, which then has the chain to itself. Allocates.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/messages.hpp"
#include "mapper/submaps/place_sketch.hpp"
#include "mapper/submaps/placed_submaps.hpp"
#include "mapper/submaps/stretch_recorder.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::submaps {

struct Submap {
  hal::TimeNs first_ns = 0;
  hal::TimeNs last_ns = 0;
  hal::TimeNs anchor_ns = 0;  ///< when the camera was there
  hal::Pose T_world_stored;   ///< where the grid of its voxels stands; nowhere else until it is corrected
  hal::Pose T_stored_anchor;  ///< the camera half-way: what its pose is about
  struct Station {
    hal::Pose T_stored_station;  ///< upright
    PlaceSketch sketch;          ///< in its frame
  };
  std::vector<Station> stations;              ///< where the camera was half-way, of all that it was made of
  double way_m = 0.0;                         ///< from the anchor before to this one
  double turn_rad = 0.0;                      ///< the same, all turns added up
  double held_s = 0.0;                        ///< the same, time in which odometry alone knew the way
  std::unique_ptr<ShelvedContents> contents;  ///< voxels, surfaces, space

  [[nodiscard]] hal::Pose T_world_anchor() const { return hal::compose(T_world_stored, T_stored_anchor); }
};

struct Surroundings {
  std::unique_ptr<VoxelMap> space;           ///< coarse: see SpaceSketch
  std::vector<align::DepthSample> surfaces;  ///< fine
};

class SubmapChain {
 public:
  /// `view`: the map that frames go into, empty or with what is known from the start; outlives the chain. So does
  /// `shelf`, if there is one.
  SubmapChain(VoxelMap& view, const ChainOptions& options = {}, SubmapShelf* shelf = nullptr);

  /// As StretchRecorder::add_frame(). True: time to finish the submap.
  bool add_frame(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera, std::span<const std::uint32_t> changed_slots,
                 std::span<const align::DepthSample> samples = {}, bool is_held = false) {
    return recorder_.add_frame(stamp_ns, T_world_camera, changed_slots, samples, is_held);
  }
  /// Keeps what has changed; `space` is what the same frames have said about space, if anybody asks for surroundings.
  /// False if there was no frame since the last one.
  bool finish_submap(std::unique_ptr<VoxelMap> space = nullptr);
  /// The two parts of that: the recorder is the view's writer's, and a stretch that it has taken becomes a submap by
  /// add(), which clears it.
  [[nodiscard]] StretchRecorder& recorder() { return recorder_; }
  [[nodiscard]] const StretchRecorder& recorder() const { return recorder_; }
  void add(Stretch& stretch, std::unique_ptr<VoxelMap> space = nullptr);

  [[nodiscard]] std::span<const Submap> submaps() const { return submaps_; }
  /// One of them and the next become one, which stands where the first did; the next goes on standing to it as it does.
  /// What they say is the same, to the bit if both stand alike. Returns how the first one's anchor stood to the next's.
  hal::Pose join(std::size_t submap);
  /// The submaps as they would stand at these poses, one each. Where they do stand does not change.
  [[nodiscard]] std::unique_ptr<PlacedSubmaps> placed_at(std::span<const hal::Pose> T_world_stored) const;
  /// Where each stands from now on; one pose each. The view is as it was until rebuild(). `placed`: the same submaps at
  /// these poses, if somebody has them already.
  void place(std::span<const hal::Pose> T_world_stored, std::unique_ptr<PlacedSubmaps> placed = nullptr);
  [[nodiscard]] const VoxelMap& view() const { return view_; }
  /// The view from the submaps alone: only after finish_submap() and before the next frame. `is_wanted`: of regions;
  /// the view is empty in the others.
  void rebuild(const std::function<bool(RegionKey)>& is_wanted = {});
  /// One block of it, stored codes. False if no submap knows any voxel of it.
  bool read_block(BlockKey key, BlockValues& out) { return placed_->read_block(key, out); }
  /// All of them where they stand.
  [[nodiscard]] const PlacedSubmaps& placed() const { return *placed_; }
  /// Contents of submaps that are nowhere near go to the shelf, if there is one: all that have nothing within
  /// `radius_cells` of `camera`.
  void put_away_far(const VoxelIndex& camera, std::int64_t radius_cells);
  /// Those that were used last stay in memory, so many of them.
  void put_away_all_but(std::size_t kept);
  [[nodiscard]] std::size_t in_memory() const;
  /// What the frames of a part of the chain have shown, in the frame of one anchor.
  [[nodiscard]] Surroundings surroundings(std::size_t first, std::size_t end, std::size_t at) const;

  /// By how much a frame's pose is to be corrected that was mapped at that time.
  [[nodiscard]] hal::Pose correction_at(hal::TimeNs stamp_ns) const;
  [[nodiscard]] std::uint64_t memory_bytes() const;
  /// Blocks for which the view had no memory when it was made anew, all times together.
  [[nodiscard]] std::uint64_t refused_blocks() const { return refused_blocks_; }

 private:
  VoxelMap& view_;
  SubmapShelf* shelf_;
  StretchRecorder recorder_;
  std::unique_ptr<Stretch> own_stretch_;  ///< of finish_submap()
  std::vector<Submap> submaps_;
  std::unique_ptr<PlacedSubmaps> placed_;
  std::uint64_t refused_blocks_ = 0;
};

}  // namespace g3d::mapper::submaps
