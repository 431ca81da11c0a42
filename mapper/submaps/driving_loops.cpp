// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/driving_loops.hpp"

#include <thread>
#include <utility>

namespace g3d::mapper::submaps {
namespace {

CloserOptions on_floor(CloserOptions options) {
  options.on_floor = true;
  return options;
}

}  // namespace

DrivingLoops::DrivingLoops(VoxelMap& view, const hal::CameraModel& camera, const DrivingOptions& options,
                           std::function<void(const ChainMove&)> on_moved)
    : options_(options),
      on_moved_(std::move(on_moved)),
      sketch_(camera),
      chain_(view, options.chain),
      stretch_(view),
      closer_(on_floor(options.closer)),
      view_move_(view, options.most_blocks_per_frame) {}

bool DrivingLoops::end_stretch() {
  if (!chain_.recorder().take(stretch_)) return false;
  sketch_.end();
  return true;
}

void DrivingLoops::add(const hal::Frame& frame, const align::AlignResult& placed,
                       std::span<const align::DepthSample> samples, std::span<const std::uint32_t> changed_slots) {
  sketch_.add(frame, placed.T_world_camera);
  const bool is_full =
      chain_.add_frame(frame.stamp_ns, placed.T_world_camera, changed_slots, samples, placed.is_held());
  if (!is_full || errand_.is_busy() || !chain_lease_.try_take()) return;
  if (!end_stretch()) return chain_lease_.give_back();
  asked_ns_ = frame.stamp_ns;
  errand_.start([this] { search(); });
}

void DrivingLoops::search() {
  chain_.add(stretch_, sketch_.take_ended());
  join_old(chain_, closer_, options_.join);
  if (!closer_.add_submap(chain_)) return;
  placed_ = chain_.placed_at(closer_.T_world_stored());
  whole_ = placed_->whole();
}

void DrivingLoops::wait_if_due(hal::TimeNs stamp_ns) {
  if (options_.is_lockstep && (is_moving() || is_due(stamp_ns))) errand_.wait();
}

bool DrivingLoops::begins_to_move(hal::TimeNs stamp_ns) {
  return is_due(stamp_ns) && errand_.is_done() && take_answer();
}

// What was seen since the question goes along with what was seen right before it.
bool DrivingLoops::take_answer() {
  errand_.take();
  if (placed_ == nullptr) {
    chain_lease_.give_back();
    return false;
  }
  has_fresh_ = end_stretch();
  phase_ = Phase::preparing;
  errand_.start([this] { prepare(); });
  return true;
}

void DrivingLoops::prepare() {
  if (has_fresh_) {
    chain_.add(stretch_, sketch_.take_ended());
    closer_.add_following(chain_);
  }
  move_ = ChainMove(chain_.submaps(), closer_.T_world_stored());
  chain_.place(closer_.T_world_stored(), std::move(placed_));
  view_move_.begin(chain_, std::move(whole_), has_fresh_ ? 1 : 0);
}

void DrivingLoops::settle() {
  view_move_.end();
  if (on_moved_) on_moved_(move_);
}

std::span<const std::uint32_t> DrivingLoops::move_on() {
  if (phase_ != Phase::moving) {
    if (!errand_.is_done()) return {};
    errand_.take();
    phase_ = phase_ == Phase::preparing ? Phase::moving : Phase::mapping;
    if (phase_ == Phase::mapping) {
      chain_lease_.give_back();
      return {};
    }
  }
  const auto slots = view_move_.go_on();
  if (view_move_.is_done()) {
    phase_ = Phase::settling;
    errand_.start([this] { settle(); });
  }
  return slots;
}

void DrivingLoops::move_to_the_end() {
  while (is_moving()) {
    errand_.wait();
    (void)move_on();
  }
}

void DrivingLoops::finish() {
  move_to_the_end();
  if (errand_.is_busy()) {
    errand_.wait();
    if (take_answer()) move_to_the_end();
  }
  take_chain();
  if (!end_stretch()) return chain_lease_.give_back();
  errand_.start([this] { search(); });
  errand_.wait();
  if (take_answer()) move_to_the_end();
}

// Who has borrowed it gives it back within a round of sharing, and nothing is driven by the map any more.
void DrivingLoops::take_chain() {
  while (!chain_lease_.try_take()) std::this_thread::yield();
}

CloserReport DrivingLoops::report() const {
  CloserReport report = closer_.report();
  report.memory_bytes = chain_.memory_bytes();
  report.refused_blocks = view_move_.refused_blocks();
  return report;
}

}  // namespace g3d::mapper::submaps
