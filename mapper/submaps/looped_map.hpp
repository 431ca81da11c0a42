// SPDX-License-Identifier: Apache-2.0
// A map whose frames are aligned, and that is put right when a place is recognised: aligner, chain of submaps, loops.
//
//   per frame:   align() ──▶ prepare() ──▶ the caller integrates it into the view ──▶ add()
//
// When add() finishes a submap and loops move the chain, the view is made anew, the surfaces to align to move along,
// and the next frame is aligned in the corrected map. With a page file the view is a window around the camera, and the
// map may be larger than memory. Thread: the one that maps; finishing a submap allocates and may
// take a second, so it is for maps that can wait. The same frames and poses give the same bits everywhere.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/submaps/join_old.hpp"
#include "mapper/submaps/loop_closer.hpp"
#include "mapper/submaps/space_sketch.hpp"
#include "mapper/submaps/submap_blocks.hpp"
#include "mapper/submaps/submap_chain.hpp"
#include "mapper/submaps/view_window.hpp"

namespace g3d::mapper::submaps {

struct LoopedOptions {
  align::AlignOptions align;
  ChainOptions chain;
  CloserOptions closer;
  JoinRule join;
  ViewWindowConfig window;  ///< for those with a page file
};

class LoopedMap {
 public:
  /// `view`: as for SubmapChain. Without `pages` all of it stays in memory.
  LoopedMap(VoxelMap& view, const hal::CameraModel& camera, const LoopedOptions& options = {},
            std::unique_ptr<PageFile> pages = nullptr);

  /// As Aligner::align().
  const align::AlignResult& align(const hal::Frame& frame, const hal::Pose& T_odometry_camera,
                                  const align::SeenSpace* space = nullptr);
  /// Has the view hold what the frame that was aligned last may see.
  void prepare();
  /// The frame that was aligned last is in the view now. True: all has been corrected, and any block of the view may
  /// have changed, or gone.
  bool add(const hal::Frame& frame, std::span<const std::uint32_t> changed_slots);
  /// What is there since the last submap becomes one, as after the last frame. Returns as add().
  bool finish();

  /// Where a frame was that was mapped at that time with that pose, as far as is known by now.
  [[nodiscard]] hal::Pose corrected(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera) const {
    return hal::compose(chain_.correction_at(stamp_ns), T_world_camera);
  }
  [[nodiscard]] const align::Aligner& aligner() const { return aligner_; }
  [[nodiscard]] const SubmapChain& chain() const { return chain_; }
  [[nodiscard]] std::span<const GraphEdge> edges() const { return closer_.graph().edges(); }
  [[nodiscard]] CloserReport report() const;
  // With a page file. After finish()
  [[nodiscard]] bool is_windowed() const { return window_ != nullptr; }
  [[nodiscard]] ViewWindow& window() { return *window_; }
  [[nodiscard]] const SubmapShelf& shelf() const { return *shelf_; }
  /// All of the map, wherever it lies.
  [[nodiscard]] SubmapBlocks whole_map() { return {chain_, *window_}; }

 private:
  align::Aligner aligner_;
  SpaceSketch sketch_;
  std::unique_ptr<SubmapShelf> shelf_;  ///< before the chain, which lies on it
  SubmapChain chain_;
  std::unique_ptr<ViewWindow> window_;
  JoinRule join_;
  LoopCloser closer_;
  align::AlignResult last_;
};

}  // namespace g3d::mapper::submaps
