// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/driving_loops.hpp"

#include <limits>
#include <utility>

namespace g3d::mapper::submaps {
namespace {

CloserOptions on_floor(CloserOptions options) {
  options.on_floor = true;
  return options;
}

}  // namespace

DrivingLoops::DrivingLoops(VoxelMap& view, const hal::CameraModel& camera, const DrivingOptions& options)
    : options_(options),
      sketch_(camera),
      chain_(view, options.chain),
      view_move_(view),
      search_(on_floor(options.closer), options.join) {}

void DrivingLoops::ask(hal::TimeNs stamp_ns) {
  asked_ns_ = stamp_ns;
  search_.ask(chain_);
}

bool DrivingLoops::take_answer() {
  MovedSubmaps moved = search_.take();
  if (moved.placed == nullptr) return false;
  // What was seen since the question goes along with what was seen right before it.
  const bool is_fresh = chain_.finish_submap(sketch_.take());
  LoopCloser& closer = search_.closer();
  if (is_fresh) closer.add_following(chain_);
  move_ = ChainMove(chain_.submaps(), closer.T_world_stored());
  chain_.place(closer.T_world_stored(), std::move(moved.placed));
  view_move_.begin(chain_, std::move(moved.whole), is_fresh ? 1 : 0);
  return true;
}

void DrivingLoops::wait_if_due(hal::TimeNs stamp_ns) {
  if (options_.is_lockstep && is_due(stamp_ns)) search_.wait();
}

bool DrivingLoops::begins_to_move(hal::TimeNs stamp_ns) {
  return is_due(stamp_ns) && search_.has_answer() && take_answer();
}

void DrivingLoops::add(const hal::Frame& frame, const align::AlignResult& placed,
                       std::span<const align::DepthSample> samples, std::span<const std::uint32_t> changed_slots) {
  sketch_.add(frame, placed.T_world_camera);
  const bool is_full =
      chain_.add_frame(frame.stamp_ns, placed.T_world_camera, changed_slots, samples, placed.is_held());
  if (is_full && !search_.is_busy() && chain_.finish_submap(sketch_.take())) ask(frame.stamp_ns);
}

void DrivingLoops::wait_and_move() {
  search_.wait();
  if (!take_answer()) return;
  while (is_moving()) (void)view_move_.go_on(std::numeric_limits<std::size_t>::max());
}

void DrivingLoops::finish() {
  while (is_moving()) (void)view_move_.go_on(std::numeric_limits<std::size_t>::max());
  if (search_.is_busy()) wait_and_move();
  if (!chain_.finish_submap(sketch_.take())) return;
  ask(asked_ns_);
  wait_and_move();
}

CloserReport DrivingLoops::report() const {
  CloserReport report = search_.closer().report();
  report.memory_bytes = chain_.memory_bytes();
  report.refused_blocks = view_move_.refused_blocks();
  return report;
}

}  // namespace g3d::mapper::submaps
