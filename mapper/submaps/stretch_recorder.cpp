// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/stretch_recorder.hpp"

#include <algorithm>
#include <cassert>

#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::submaps {
namespace {

constexpr std::size_t kStretchSurfaceSlots = std::size_t{1} << 17;  // 8 m^2 of surface are 1250 pieces of 8 cm
constexpr std::size_t kMostFrames = 8192;                           // half a minute at 240 Hz

std::unique_ptr<align::SurfaceMap> stretch_surfaces() {
  return std::make_unique<align::SurfaceMap>(align::SurfaceOptions{.slots = kStretchSurfaceSlots});
}

}  // namespace

Stretch::Stretch(const VoxelMap& view) : blocks(view.grid(), view.capacity()), surfaces(stretch_surfaces()) {}

void Stretch::clear() {
  blocks.clear();
  surfaces->clear();
}

StretchRecorder::StretchRecorder(const VoxelMap& view, const ChainOptions& options)
    : view_(view), options_(options), is_noted_(view.capacity().blocks), surfaces_(stretch_surfaces()) {
  changed_slots_.reserve(is_noted_.size());
  passed_.reserve(kMostFrames);
}

void StretchRecorder::note(std::uint32_t slot) {
  if (is_noted_[slot].load(std::memory_order_relaxed)) return;
  is_noted_[slot].store(true, std::memory_order_relaxed);
  changed_slots_.push_back(slot);
}

bool StretchRecorder::add_frame(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera,
                                std::span<const std::uint32_t> changed_slots,
                                std::span<const align::DepthSample> samples, bool is_held) {
  if (!has_begun_.load(std::memory_order_relaxed)) {
    // What was known before the first frame: the place where the robot stands.
    for (std::uint32_t slot = 0; slot < view_.slot_end(); ++slot) {
      if (view_.header(slot).key != VoxelMap::kNoKey) note(slot);
    }
    has_begun_.store(true, std::memory_order_release);
    last_camera_ = T_world_camera;
    last_ns_ = stamp_ns;
  }
  for (const std::uint32_t slot : changed_slots) note(slot);
  surfaces_->add(samples, hal::to_transform(T_world_camera), stamp_ns);
  const align::Vector6 step = align::difference(last_camera_, T_world_camera);
  way_m_ += align::shift_of(step);
  turn_rad_ += align::turn_of(step);
  if (is_held) held_s_ += static_cast<double>(stamp_ns - last_ns_) / 1e9;
  last_camera_ = T_world_camera;
  last_ns_ = stamp_ns;
  if (passed_.size() == kMostFrames) passed_.pop_back();
  passed_.push_back({stamp_ns, T_world_camera, way_m_, turn_rad_, held_s_});
  const double since_s = static_cast<double>(stamp_ns - passed_.front().stamp_ns) / 1e9;
  return way_m_ - way_at_end_m_ >= options_.most_way_m || turn_rad_ - turn_at_end_rad_ >= options_.most_turn_rad ||
         since_s >= options_.most_s;
}

bool StretchRecorder::take(Stretch& into) {
  if (passed_.empty()) return false;
  into.first_ns = passed_.front().stamp_ns;
  into.last_ns = passed_.back().stamp_ns;
  const double middle_m = 0.5 * (way_at_end_m_ + way_m_);
  const auto anchor =
      std::find_if(passed_.begin(), passed_.end() - 1, [&](const Passed& p) { return p.way_m >= middle_m; });
  into.anchor_ns = anchor->stamp_ns;
  into.T_world_anchor = anchor->T_world_camera;
  into.way_m = anchor->way_m;
  into.turn_rad = anchor->turn_rad;
  into.held_s = anchor->held_s;
  held_s_ -= anchor->held_s;
  way_m_ -= anchor->way_m;
  turn_rad_ -= anchor->turn_rad;
  way_at_end_m_ = way_m_;
  turn_at_end_rad_ = turn_rad_;
  passed_.clear();

  BlockValues values;
  for (const std::uint32_t slot : changed_slots_) {
    is_noted_[slot].store(false, std::memory_order_relaxed);
    const BlockKey key = view_.header(slot).key;
    if (!view_.read_stored_block(key, values)) continue;
    [[maybe_unused]] const bool fits = into.blocks.write_block(key, values);
    assert(fits);
  }
  changed_slots_.clear();
  surfaces_.swap(into.surfaces);
  return true;
}

}  // namespace g3d::mapper::submaps
