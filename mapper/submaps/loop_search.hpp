// SPDX-License-Identifier: Apache-2.0
// Looks for loops, and joins submaps that are old, in a thread of its own, so that mapping goes on meanwhile: it takes
// up to a second. One question at a time; from ask() to take() nobody looks at that chain's submaps, finishes one,
// places one, or touches the closer. Frames may be added to the chain. Thread: all calls from one, which owns the
// chain. The thread allocates, its owner does not wait for it unless it calls wait().
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "hal/parking.hpp"
#include "mapper/submaps/join_old.hpp"
#include "mapper/submaps/loop_closer.hpp"
#include "mapper/submaps/placed_submaps.hpp"
#include "mapper/submaps/submap_chain.hpp"

namespace g3d::mapper::submaps {

/// The finished submaps where LoopCloser::T_world_stored() has them.
struct MovedSubmaps {
  std::unique_ptr<PlacedSubmaps> placed;
  std::unique_ptr<VoxelMap> whole;
};

class LoopSearch {
 public:
  explicit LoopSearch(const CloserOptions& options = {}, const JoinRule& join = {});
  ~LoopSearch();
  LoopSearch(const LoopSearch&) = delete;
  LoopSearch& operator=(const LoopSearch&) = delete;

  /// The chain has a new submap. Not while it is busy.
  void ask(SubmapChain& chain);
  [[nodiscard]] bool is_busy() const { return state_.load(std::memory_order_acquire) != State::idle; }
  [[nodiscard]] bool has_answer() const { return state_.load(std::memory_order_acquire) == State::answered; }
  void wait();
  /// The answer, once there is one; it is idle from then on. Empty pointers: everything stays where it is.
  [[nodiscard]] MovedSubmaps take();
  /// While it is not busy.
  [[nodiscard]] LoopCloser& closer() { return closer_; }
  [[nodiscard]] const LoopCloser& closer() const { return closer_; }

 private:
  enum class State : std::uint8_t { idle, asked, answered };
  void work();
  void answer();

  LoopCloser closer_;
  JoinRule join_;
  SubmapChain* chain_ = nullptr;
  MovedSubmaps moved_;
  std::atomic<State> state_{State::idle};
  hal::Parking questions_;
  hal::Parking answers_;
  std::thread thread_;
};

}  // namespace g3d::mapper::submaps
