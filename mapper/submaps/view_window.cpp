// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/view_window.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapper/rolling_window.hpp"
#include "mapper/submaps/submap_blocks.hpp"

namespace g3d::mapper::submaps {
namespace {

constexpr double kStride_m = 0.5;  // less than least_radius_m() leaves as a margin
constexpr MapCapacity kRegionNeeds{kRegionBlocks, kRegionBlocks, 2 * kRegionBlocks};  // one full of surfaces
constexpr std::uint32_t kKeptFree = 8;  // one part in so many of each pool, for frames to come

}  // namespace

ViewWindow::ViewWindow(SubmapChain& chain, VoxelMap& view, const hal::CameraModel& camera,
                       const ViewWindowConfig& config)
    : chain_(chain), view_(view), sensor_(camera, view.grid().resolution_m, config.near_m, config.far_m) {
  const auto r = static_cast<double>(view.grid().resolution_m);
  const double least_m = least_radius_m(camera, config.far_m, view.grid().resolution_m);
  least_radius_cells_ = static_cast<std::int64_t>(std::ceil(least_m / r));
  full_radius_cells_ = std::max(least_radius_cells_, static_cast<std::int64_t>(config.radius_m / r));
  radius_cells_ = full_radius_cells_;
  stride_cells_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(kStride_m / r));
  counts_.smallest_radius_m = full_radius_m();
  const MapCapacity& all = view.capacity();
  reserve_ = {all.blocks / kKeptFree, all.planes / kKeptFree, all.colour_bricks / kKeptFree};
}

bool ViewWindow::aim(const hal::Pose& T_world_camera) {
  const auto frame = cpu::frame_geometry(sensor_, hal::to_transform(T_world_camera));
  if (!frame) return false;
  const auto& t = frame->translation_m;
  camera_ = view_.grid().to_index(t[0], t[1], t[2]);
  needed_ = {frame->origin, frame->last()};
  return true;
}

void ViewWindow::prepare(const hal::Pose& T_world_camera) {
  if (!aim(T_world_camera)) return;
  const std::int64_t moved_cells = std::max(
      {std::abs(camera_.x - looked_at_.x), std::abs(camera_.y - looked_at_.y), std::abs(camera_.z - looked_at_.z)});
  const bool is_roomy = radius_cells_ >= least_radius_cells_ && fits(reserve_, view_.available());
  if (has_looked_ && is_roomy && moved_cells < stride_cells_) return;
  looked_at_ = camera_;
  send_away();
  // A camera that only turns, or moves less than the stride, must find all there that is within its reach.
  has_looked_ = bring_back() && radius_cells_ >= least_radius_cells_;
  adapt_radius();
  chain_.put_away_far(camera_, radius_cells_);
}

// Blocks that have changed since the last submap are known nowhere else: their regions stay.
void ViewWindow::send_away() {
  std::unordered_set<RegionKey> held;
  std::vector<std::uint32_t> far;
  for (std::uint32_t slot = 0; slot < view_.slot_end(); ++slot) {
    const BlockKey key = view_.header(slot).key;
    if (key == VoxelMap::kNoKey || is_within(region_of(key), radius_cells_) || needed_.holds(region_of(key))) continue;
    if (chain_.recorder().is_noted(slot)) held.insert(region_of(key));
    far.push_back(slot);
  }
  has_held_ = !held.empty();
  for (const std::uint32_t slot : far) {
    const BlockKey key = view_.header(slot).key;
    const RegionKey region = region_of(key);
    if (held.count(region) > 0) continue;
    counts_.regions_out += out_.insert(region).second ? 1 : 0;
    ++counts_.blocks_out;
    view_.erase_block(key);
  }
}

bool ViewWindow::bring_back() {
  const std::int64_t ahead_cells = std::max<std::int64_t>(radius_cells_ - kRegionSide_cells, 0);
  std::vector<std::pair<std::int64_t, RegionKey>> near;  // what the frame sees first, then what is nearest
  for (const RegionKey region : out_) {
    const std::int64_t squared_cells = needed_.holds(region) ? -1 : squared_distance_cells(region, camera_);
    if (squared_cells <= ahead_cells * ahead_cells) near.emplace_back(squared_cells, region);
  }
  std::sort(near.begin(), near.end());
  for (const auto& [squared_cells, region] : near) {
    if (squared_cells >= 0 && !fits(reserve_, view_.available())) return false;
    if (squared_cells < 0) make_room(kRegionNeeds);
    fetch(region);
  }
  return true;
}

void ViewWindow::fetch(RegionKey region) {
  BlockValues values;
  for (const BlockKey key : chain_.placed().keys_in(region)) {
    if (!chain_.read_block(key, values)) continue;
    ++counts_.blocks_in;
    counts_.refused_blocks += view_.write_block(key, values) ? 0 : 1;
  }
  ++counts_.regions_in;
  out_.erase(region);
}

void ViewWindow::make_room(const MapCapacity& wanted) {
  while (!fits(wanted, view_.available()) && radius_cells_ > 0) {
    radius_cells_ = std::max<std::int64_t>(0, radius_cells_ - kRegionSide_cells);
    send_away();
  }
}

void ViewWindow::adapt_radius() {
  const MapCapacity twice{2 * reserve_.blocks, 2 * reserve_.planes, 2 * reserve_.colour_bricks};
  if (fits(twice, view_.available())) {
    radius_cells_ = std::min(full_radius_cells_, radius_cells_ + kRegionSide_cells / 8);
  }
  make_room(reserve_);
  wants_submap_ = !fits(reserve_, view_.available()) && has_held_;
  counts_.smallest_radius_m = std::min(counts_.smallest_radius_m, metres(radius_cells_));
}

void ViewWindow::rebuild(const hal::Pose& T_world_camera) {
  (void)aim(T_world_camera);
  has_looked_ = false;
  out_.clear();
  for (const RegionKey region : chain_.placed().regions()) {
    if (!needed_.holds(region)) out_.insert(region);
  }
  chain_.rebuild([&](RegionKey region) { return !is_out(region); });
  (void)bring_back();
  chain_.put_away_far(camera_, radius_cells_);
}

bool ViewWindow::gather() {
  const auto size = measure(SubmapBlocks(chain_, *this));
  if (!size.ok() || !fits(size.value().needed, view_.capacity())) return false;
  std::vector<RegionKey> all(out_.begin(), out_.end());
  std::sort(all.begin(), all.end());
  for (const RegionKey region : all) {
    fetch(region);
    chain_.put_away_all_but(SubmapBlocks::kKept);
  }
  return true;
}

}  // namespace g3d::mapper::submaps
