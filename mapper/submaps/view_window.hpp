// SPDX-License-Identifier: Apache-2.0
// Keeps in the view what is around the camera; the rest is in the submaps, and those that have nothing near lie on the
// shelf as a whole. Before each frame, if the camera has moved some way:
//
//        camera ├── within reach of a frame ──┤── stays ──┤── leaves, region by region ──▶ distance
//                 comes back from the submaps               unless it has changed since the last submap
//
// Where a frame may look the view is what it would be without a window, so the map is the same to the bit. When memory
// runs low the radius shrinks, down to nothing but the frame's own box, and recovers once there is room. Thread: the
// view's writer; it waits for the disk and allocates, so it is for maps that can wait.
#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "hal/messages.hpp"
#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/region.hpp"
#include "mapper/submaps/submap_chain.hpp"

namespace g3d::mapper::submaps {

struct ViewWindowConfig {
  double radius_m = 15.0;  ///< raised to what the sensor's reach needs: see least_radius_m()
  float near_m = 0.8F;     ///< of the mapper
  float far_m = 4.0F;      ///< as well
};

struct ViewWindowCounts {
  std::uint64_t regions_out = 0;
  std::uint64_t regions_in = 0;
  std::uint64_t blocks_out = 0;
  std::uint64_t blocks_in = 0;
  std::uint64_t refused_blocks = 0;  ///< that came back when there was no memory for them
  double smallest_radius_m = 0.0;
};

class ViewWindow {
 public:
  /// `view`: the chain's, nobody else writes to it meanwhile. Both outlive this.
  ViewWindow(SubmapChain& chain, VoxelMap& view, const hal::CameraModel& camera, const ViewWindowConfig& config);

  /// Before a frame is mapped at that pose.
  void prepare(const hal::Pose& T_world_camera);
  /// Whether memory is so short that the current submap should end: what it has changed cannot leave before.
  [[nodiscard]] bool wants_submap() const { return wants_submap_; }
  /// After submaps have been moved: instead of SubmapChain::rebuild().
  void rebuild(const hal::Pose& T_world_camera);
  /// Brings everything back, if the view can hold it: true. Only after finish_submap().
  [[nodiscard]] bool gather();

  [[nodiscard]] bool is_out(RegionKey region) const { return out_.count(region) > 0; }
  [[nodiscard]] std::size_t out_count() const { return out_.size(); }
  [[nodiscard]] const ViewWindowCounts& counts() const { return counts_; }
  [[nodiscard]] double full_radius_m() const { return metres(full_radius_cells_); }

 private:
  [[nodiscard]] double metres(std::int64_t cells) const {
    return static_cast<double>(cells) * static_cast<double>(view_.grid().resolution_m);
  }
  /// False: no frame can be mapped there.
  [[nodiscard]] bool aim(const hal::Pose& T_world_camera);
  [[nodiscard]] bool is_within(RegionKey region, std::int64_t cells) const {
    return squared_distance_cells(region, camera_) <= cells * cells;
  }
  /// False: not all that is near, for want of memory.
  bool bring_back();
  void fetch(RegionKey region);
  void send_away();
  /// As far as sending away what is not needed gives it.
  void make_room(const MapCapacity& wanted);
  void adapt_radius();

  SubmapChain& chain_;
  VoxelMap& view_;
  std::unordered_set<RegionKey> out_;
  ViewWindowCounts counts_;
  MapCapacity reserve_;
  std::int64_t full_radius_cells_ = 0;
  std::int64_t least_radius_cells_ = 0;
  std::int64_t radius_cells_ = 0;  ///< shrinks when memory is short
  std::int64_t stride_cells_ = 1;  ///< the camera's between two looks at all this
  cpu::SensorGeometry sensor_;
  VoxelIndex camera_;
  VoxelIndex looked_at_;     ///< where the camera was when all this was looked at
  RegionBox needed_;         ///< the frame's box
  bool has_looked_ = false;  ///< and found room for all that frames from around there may see
  bool has_held_ = false;    ///< regions that are far, but have changed since the last submap
  bool wants_submap_ = false;
};

}  // namespace g3d::mapper::submaps
