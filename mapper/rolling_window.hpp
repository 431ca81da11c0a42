// SPDX-License-Identifier: Apache-2.0
// Keeps in memory what is around the camera and the rest on disk, so that a walk of any length fits into the pools.
// Before each frame:
//
//        camera ├── the frame's box ──┤── ahead ──┤── stays ──┤── leaves ──▶ distance
//                 must be in memory     is fetched             beyond the radius, farthest first
//
// Lockstep: whatever is asked of the pager is waited for, so that the map is what it would be without a window.
// Real time: the mapper thread never waits. A region that is seen before it is back starts anew, is counted (late), and
// is merged when it arrives; a region that changes while it is being stored stays.
// When a pool runs low the radius shrinks, farthest regions first, and recovers once there is room. What cannot be
// stored (full disk) stays in memory. Thread: mapper thread; after construction nothing in it allocates.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/mapper.hpp"
#include "mapper/pager.hpp"
#include "mapper/region_table.hpp"
#include "mapper/windowed_blocks.hpp"

namespace g3d::mapper {

struct WindowConfig {
  double radius_m = 15.0;  ///< raised to what the sensor's reach needs: see least_radius_m()
  bool lockstep = true;
  std::uint32_t regions_per_frame = 4;   ///< at most as many leave for their distance, and as many are fetched ahead
  std::uint32_t buffers = 8;             ///< regions on their way, about 1 MB each
  std::uint32_t max_regions = 1U << 18;  ///< known at all, in memory and on disk
};

struct WindowCounts {
  std::uint64_t regions_out = 0;
  std::uint64_t regions_in = 0;
  std::uint64_t blocks_out = 0;
  std::uint64_t blocks_in = 0;
  std::uint64_t taken_back = 0;         ///< changed while they were being stored: they stayed
  std::uint64_t late_regions = 0;       ///< seen while they were on disk
  std::uint64_t no_room = 0;            ///< came back, but the pools had no room: still on disk
  std::uint64_t failed_stores = 0;      ///< those regions stay in memory
  std::uint64_t failed_loads = 0;       ///< those regions cannot be read any more
  std::uint64_t unmanaged_regions = 0;  ///< the table was full: never paged out
  double smallest_radius_m = 0.0;
};

class RollingWindow {
 public:
  /// The mapper outlives the window. Nobody else writes to its map while the window runs.
  RollingWindow(Mapper& mapper, const hal::CameraModel& camera, const WindowConfig& config,
                std::unique_ptr<PageFile> file);

  /// Before each Mapper::integrate(), with the same pose.
  void prepare(const hal::Pose& T_world_camera);
  /// After the last frame: brings to an end what is under way. Then the rest may be asked.
  void finish();

  [[nodiscard]] const WindowCounts& counts() const { return counts_; }
  [[nodiscard]] WindowedBlocks whole_map() { return {map_, pager_.store()}; }
  [[nodiscard]] PageStore& store() { return pager_.store(); }
  /// What went wrong first on the disk; empty if nothing did.
  [[nodiscard]] const std::string& first_error() const { return pager_.first_error(); }
  [[nodiscard]] double radius_m() const;       ///< as it is now
  [[nodiscard]] double full_radius_m() const;  ///< while memory suffices

 private:
  struct Target {
    RegionKey region = 0;
    std::int64_t squared_cells = 0;
  };

  void note_changes();
  void touch(BlockKey key);
  void aim(const cpu::FrameGeometry& frame);
  void learn_growth();
  void adapt_radius();
  [[nodiscard]] bool is_store_allowed() const;

  [[nodiscard]] bool find_farthest(std::int64_t beyond_squared_cells, Target& found);
  bool make_room(const MapCapacity& wanted);
  void page_out_far();
  bool page_out(RegionKey region);
  void load_needed();
  void load_ahead();
  bool load(RegionKey region, RegionState& state);

  void take_results();
  void drain();
  void handle(const PageResult& result);
  void on_stored(std::uint32_t buffer, bool ok);
  void on_loaded(std::uint32_t buffer, bool ok);

  Mapper& mapper_;
  VoxelMap& map_;
  WindowConfig config_;
  cpu::SensorGeometry sensor_;
  Pager pager_;
  RegionTable regions_;
  WindowCounts counts_;

  // Distances in voxels
  std::int64_t full_radius_cells_ = 0;
  std::int64_t radius_cells_ = 0;  ///< shrinks when memory is short
  std::int64_t ahead_cells_ = 0;

  // This frame
  VoxelIndex camera_;
  RegionBox needed_;  ///< the frame's box

  // Memory
  MapCapacity least_reserve_;  ///< kept free for one frame
  MapCapacity reserve_;
  MapCapacity left_last_;         ///< available after the last prepare()
  MapCapacity leaving_{0, 0, 0};  ///< will be free once stored
  std::uint32_t on_disk_count_ = 0;
  int frames_until_retry_ = 0;
  bool started_ = false;
};

/// Smaller radii would page out what the camera may see when it turns.
[[nodiscard]] double least_radius_m(const hal::CameraModel& camera, float far_m, float resolution_m);

}  // namespace g3d::mapper
