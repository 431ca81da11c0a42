// SPDX-License-Identifier: Apache-2.0
// Submaps and loops for a robot that drives while it maps. Nothing here holds up a frame: submaps are made and loops
// are looked for beside the mapping, and when the map is to move the robot stands for some frames, in which what is
// long is done beside as well, and the map itself is moved a part at a time.
//
//   per frame:  begins_to_move()? ── no ──▶ map it ──▶ add()
//                     │ yes: stand still
//                     ▼
//               move_on() instead of mapping, until is_moving() is false; then everything that knows a place in
//               the old map is moved by move(), and driving goes on
//
// In lockstep, where the same frames give the same map, what is done beside is waited for: wait_if_due() before each
// frame. Thread: the one that maps. What is done beside allocates; the rest does not, but for finish().
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "hal/errand.hpp"
#include "hal/lease.hpp"
#include "hal/messages.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/submaps/chain_move.hpp"
#include "mapper/submaps/join_old.hpp"
#include "mapper/submaps/loop_closer.hpp"
#include "mapper/submaps/placed_submaps.hpp"
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
  /// `view`: as for SubmapChain. `on_moved` is called beside, once the view has moved and before is_moving() is false:
  /// for what takes long and what nobody uses while the map moves.
  DrivingLoops(VoxelMap& view, const hal::CameraModel& camera, const DrivingOptions& options = {},
               std::function<void(const ChainMove&)> on_moved = {});

  /// In lockstep: until what this frame needs is there. Else it does nothing.
  void wait_if_due(hal::TimeNs stamp_ns);
  /// Before a frame is aligned. True: it must not go into the map, for that is about to move.
  [[nodiscard]] bool begins_to_move(hal::TimeNs stamp_ns);
  [[nodiscard]] bool is_moving() const { return phase_ != Phase::mapping; }
  /// A step of the move. Returns the slots that it has changed, each once, until the next call.
  std::span<const std::uint32_t> move_on();
  /// Of the last correction. Once it has moved.
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
  /// By whom it may be read: who has borrowed it, and anybody after finish().
  [[nodiscard]] const SubmapChain& chain() const { return chain_; }
  /// Any thread. True: nobody works on the chain, and nobody begins to until give_back_chain(). For a part of a second
  /// at most: a submap that is due meanwhile is begun with the next frame.
  [[nodiscard]] bool try_borrow_chain() const { return chain_lease_.try_take(); }
  void give_back_chain() const { chain_lease_.give_back(); }

 private:
  enum class Phase : std::uint8_t {
    mapping,    ///< perhaps a search is under way
    preparing,  ///< beside: what the move needs
    moving,     ///< here, part by part
    settling,   ///< beside: what comes after
  };
  [[nodiscard]] bool is_due(hal::TimeNs stamp_ns) const {
    return errand_.is_busy() && stamp_ns - asked_ns_ >= options_.answer_after_ns;
  }
  /// False: no frame was added since the last time.
  [[nodiscard]] bool end_stretch();
  [[nodiscard]] bool take_answer();
  void move_to_the_end();
  void take_chain();
  // Beside
  void search();
  void prepare();
  void settle();

  DrivingOptions options_;
  std::function<void(const ChainMove&)> on_moved_;
  SpaceSketch sketch_;
  SubmapChain chain_;
  Stretch stretch_;
  LoopCloser closer_;
  ViewMove view_move_;
  ChainMove move_;
  Phase phase_ = Phase::mapping;
  mutable hal::Lease chain_lease_;  ///< ours from a question until its answer is dealt with
  hal::TimeNs asked_ns_ = 0;
  bool has_fresh_ = false;                 ///< a stretch since the question
  std::unique_ptr<PlacedSubmaps> placed_;  ///< the search's answer: nothing if all stays where it is
  std::unique_ptr<VoxelMap> whole_;        ///< the same as a map
  hal::Errand errand_;                     ///< last: its jobs use the rest
};

}  // namespace g3d::mapper::submaps
