// SPDX-License-Identifier: Apache-2.0
// Submaps and loops for a robot that drives while it maps. Nothing here holds up a frame: loops are looked for beside
// the mapping, and when the map is to move the robot stands for some frames in which a part of it is moved each.
//
// In lockstep, where the same frames give the same map, the search is waited for: wait_if_due() before
// begins_to_move().
//
//   per frame:  begins_to_move()? ── no ──▶ map it ──▶ add()
//                     │ yes: stand still
//                     ▼
//               move_on() instead of mapping, until is_moving() is false; then everything that knows a place in
//               the old map is moved by move(), and driving goes on
//
// Thread: the one that maps. begins_to_move() allocates when the map begins to move, add() when a submap is finished.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/messages.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/submaps/chain_move.hpp"
#include "mapper/submaps/loop_search.hpp"
#include "mapper/submaps/space_sketch.hpp"
#include "mapper/submaps/submap_chain.hpp"
#include "mapper/submaps/view_move.hpp"

namespace g3d::mapper::submaps {

struct DrivingOptions {
  ChainOptions chain;
  CloserOptions closer;
  JoinRule join;
  hal::TimeNs answer_after_ns = 2'000'000'000;  ///< an answer is looked at so long after the question at the earliest
  bool is_lockstep = false;
  std::size_t most_blocks_per_frame = 2048;  ///< of a move
};

class DrivingLoops {
 public:
  /// `view`: as for SubmapChain.
  DrivingLoops(VoxelMap& view, const hal::CameraModel& camera, const DrivingOptions& options = {});

  /// In lockstep: until the search has found what it has to answer for this frame. Else it does nothing.
  void wait_if_due(hal::TimeNs stamp_ns);
  /// Before a frame is aligned. True: it must not go into the map, for that is about to move.
  [[nodiscard]] bool begins_to_move(hal::TimeNs stamp_ns);
  [[nodiscard]] bool is_moving() const { return !view_move_.is_done(); }
  /// The next part. Returns the slots that it has changed, each once, until the next call.
  std::span<const std::uint32_t> move_on() { return view_move_.go_on(options_.most_blocks_per_frame); }
  /// Of the last correction.
  [[nodiscard]] const ChainMove& move() const { return move_; }

  /// A frame is in the view now. `samples`: its surfaces, see Aligner::samples().
  void add(const hal::Frame& frame, const align::AlignResult& placed, std::span<const align::DepthSample> samples,
           std::span<const std::uint32_t> changed_slots);
  /// After the last frame: what is there becomes a submap, loops are waited for, and the map moves at once as a whole.
  void finish();

  /// Where a frame was that was mapped at that time with that pose, as far as is known by now. Not while a search is
  /// under way: after finish().
  [[nodiscard]] hal::Pose corrected(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera) const {
    return hal::compose(chain_.correction_at(stamp_ns), T_world_camera);
  }
  /// After finish().
  [[nodiscard]] CloserReport report() const;
  [[nodiscard]] const SubmapChain& chain() const { return chain_; }

 private:
  [[nodiscard]] bool is_due(hal::TimeNs stamp_ns) const {
    return search_.is_busy() && stamp_ns - asked_ns_ >= options_.answer_after_ns;
  }
  void ask(hal::TimeNs stamp_ns);
  [[nodiscard]] bool take_answer();
  void wait_and_move();

  DrivingOptions options_;
  SpaceSketch sketch_;
  SubmapChain chain_;
  ViewMove view_move_;
  ChainMove move_;
  hal::TimeNs asked_ns_ = 0;
  LoopSearch search_;  ///< last: its thread reads the chain
};

}  // namespace g3d::mapper::submaps
