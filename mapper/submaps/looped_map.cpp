// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/looped_map.hpp"

#include <utility>

#include "mapper/submaps/chain_move.hpp"

namespace g3d::mapper::submaps {

LoopedMap::LoopedMap(VoxelMap& view, const hal::CameraModel& camera, const LoopedOptions& options,
                     std::unique_ptr<PageFile> pages)
    : aligner_(options.align, camera),
      sketch_(camera),
      shelf_(pages != nullptr ? std::make_unique<SubmapShelf>(std::move(pages)) : nullptr),
      chain_(view, options.chain, shelf_.get()),
      window_(shelf_ != nullptr ? std::make_unique<ViewWindow>(chain_, view, camera, options.window) : nullptr),
      join_(options.join),
      closer_(options.closer) {}

const align::AlignResult& LoopedMap::align(const hal::Frame& frame, const hal::Pose& T_odometry_camera,
                                           const align::SeenSpace* space) {
  last_ = aligner_.align(frame, T_odometry_camera, space);
  return last_;
}

void LoopedMap::prepare() {
  if (window_ != nullptr) window_->prepare(last_.T_world_camera);
}

bool LoopedMap::add(const hal::Frame& frame, std::span<const std::uint32_t> changed_slots) {
  sketch_.add(frame, last_.T_world_camera);
  const bool is_due =
      chain_.add_frame(frame.stamp_ns, last_.T_world_camera, changed_slots, aligner_.samples(), last_.is_held());
  return (is_due || (window_ != nullptr && window_->wants_submap())) && finish();
}

CloserReport LoopedMap::report() const {
  CloserReport report = closer_.report();
  report.memory_bytes = chain_.memory_bytes();
  report.refused_blocks = chain_.refused_blocks() + (window_ != nullptr ? window_->counts().refused_blocks : 0);
  return report;
}

bool LoopedMap::finish() {
  if (!chain_.finish_submap(sketch_.take())) return false;
  join_old(chain_, closer_, join_);
  if (!closer_.add_submap(chain_)) return false;
  const ChainMove move(chain_.submaps(), closer_.T_world_stored());
  chain_.place(closer_.T_world_stored());
  if (window_ != nullptr) {
    window_->rebuild(hal::compose(move.newest(), last_.T_world_camera));
  } else {
    chain_.rebuild();
  }
  aligner_.correct(move.newest(), [&](hal::TimeNs born_ns) { return move.at(born_ns); });
  return true;
}

}  // namespace g3d::mapper::submaps
