// SPDX-License-Identifier: Apache-2.0
#include "mapper/rolling_window.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper {
namespace {

constexpr double kAheadMargin_m = 1.0;  // how much farther than the sensor reaches regions are fetched
constexpr int kRetryFrames = 30;        // after a failed store: the disk may have room again
constexpr std::uint32_t kBuffersForLoads = 2;

MapCapacity operator+(const MapCapacity& a, const MapCapacity& b) {
  return {a.blocks + b.blocks, a.planes + b.planes, a.colour_bricks + b.colour_bricks};
}

MapCapacity operator-(const MapCapacity& a, const MapCapacity& b) {
  return {a.blocks - b.blocks, a.planes - b.planes, a.colour_bricks - b.colour_bricks};
}

double reach_m(const hal::CameraModel& camera, double far_m) {
  const double x = static_cast<double>(std::max(camera.cx_px, static_cast<float>(camera.width_px) - camera.cx_px)) /
                   static_cast<double>(camera.fx_px);
  const double y = static_cast<double>(std::max(camera.cy_px, static_cast<float>(camera.height_px) - camera.cy_px)) /
                   static_cast<double>(camera.fy_px);
  return far_m * std::sqrt(1.0 + x * x + y * y);
}

// A frame can make as many blocks as its frustum has room for, and some at its faces.
std::uint32_t frustum_blocks(const hal::CameraModel& camera, double far_m, double resolution_m) {
  const double volume_m3 = far_m * far_m * far_m / 3.0 * camera.width_px / static_cast<double>(camera.fx_px) *
                           camera.height_px / static_cast<double>(camera.fy_px);
  return static_cast<std::uint32_t>(std::min(1.3 * volume_m3 / std::pow(8.0 * resolution_m, 3.0), 1e8));
}

}  // namespace

double least_radius_m(const hal::CameraModel& camera, float far_m, float resolution_m) {
  return reach_m(camera, static_cast<double>(far_m)) + kAheadMargin_m +
         kRegionSide_cells * static_cast<double>(resolution_m);
}

RollingWindow::RollingWindow(Mapper& mapper, const hal::CameraModel& camera, const WindowConfig& config,
                             std::unique_ptr<PageFile> file)
    : mapper_(mapper),
      map_(mapper.map()),
      config_(config),
      sensor_(camera, mapper.config().resolution_m, mapper.config().near_m, mapper.config().far_m),
      pager_(std::move(file), config.max_regions, std::max(config.buffers, kBuffersForLoads + 2)),
      regions_(config.max_regions) {
  const double r = static_cast<double>(mapper.config().resolution_m);
  const double far_m = static_cast<double>(mapper.config().far_m);
  const double least_m = least_radius_m(camera, mapper.config().far_m, mapper.config().resolution_m);
  full_radius_cells_ = static_cast<std::int64_t>(std::max(config.radius_m, least_m) / r);
  radius_cells_ = full_radius_cells_;
  ahead_cells_ = static_cast<std::int64_t>((reach_m(camera, far_m) + kAheadMargin_m) / r);
  counts_.smallest_radius_m = radius_m();
  const MapCapacity& capacity = map_.capacity();
  const std::uint32_t blocks = frustum_blocks(camera, far_m, r);
  least_reserve_ = {std::min(blocks, capacity.blocks / 4), std::min(blocks / 2, capacity.planes / 4),
                    std::min(blocks / 2, capacity.colour_bricks / 4)};
  reserve_ = least_reserve_;
  left_last_ = map_.available();
}

double RollingWindow::radius_m() const {
  return static_cast<double>(radius_cells_) * static_cast<double>(map_.grid().resolution_m);
}

double RollingWindow::full_radius_m() const {
  return static_cast<double>(full_radius_cells_) * static_cast<double>(map_.grid().resolution_m);
}

void RollingWindow::prepare(const hal::Pose& T_world_camera) {
  note_changes();
  learn_growth();
  take_results();
  if (frames_until_retry_ > 0) --frames_until_retry_;
  const auto frame = cpu::frame_geometry(sensor_, hal::to_transform(T_world_camera));
  if (frame) {  // else the mapper refuses it as well
    aim(*frame);
    make_room(reserve_);
    load_needed();
    page_out_far();
    load_ahead();
    adapt_radius();
  }
  left_last_ = map_.available();
}

void RollingWindow::finish() {
  note_changes();
  drain();
  pager_.stop();
}

// What was in the map before the first frame counts as changed: a footprint, or a map that was loaded.
void RollingWindow::note_changes() {
  if (!started_) {
    for (std::uint32_t slot = 0; slot < map_.slot_end(); ++slot) touch(map_.header(slot).key);
    started_ = true;
  }
  for (const std::uint32_t slot : mapper_.changed_slots()) touch(map_.header(slot).key);
}

void RollingWindow::touch(BlockKey key) {
  if (key == VoxelMap::kNoKey) return;
  RegionState* state = regions_.find(region_of(key));
  if (state == nullptr || !state->resident()) {
    if (state != nullptr) ++counts_.late_regions;
    state = regions_.add_resident(region_of(key));
    if (state == nullptr) {
      ++counts_.unmanaged_regions;
      return;
    }
  }
  state->touched = true;
}

void RollingWindow::aim(const cpu::FrameGeometry& frame) {
  const auto& t = frame.translation_m;
  camera_ = map_.grid().to_index(t[0], t[1], t[2]);
  needed_ = {frame.origin, frame.last()};
}

// Room for twice what the hungriest frame took, at least for a frustum of new space, at most for half of the pool.
void RollingWindow::learn_growth() {
  const MapCapacity now = map_.available();
  const auto learn = [](std::uint32_t& reserve, std::uint32_t before, std::uint32_t after, std::uint32_t capacity) {
    const std::uint32_t grown = before > after ? before - after : 0;
    reserve = std::min(std::max(reserve, 2 * grown), capacity / 2);
  };
  learn(reserve_.blocks, left_last_.blocks, now.blocks, map_.capacity().blocks);
  learn(reserve_.planes, left_last_.planes, now.planes, map_.capacity().planes);
  learn(reserve_.colour_bricks, left_last_.colour_bricks, now.colour_bricks, map_.capacity().colour_bricks);
}

// Shrinking happens where room is made; here the radius recovers, slowly, so that it does not swing.
void RollingWindow::adapt_radius() {
  counts_.smallest_radius_m = std::min(counts_.smallest_radius_m, radius_m());
  if (!fits(reserve_ + reserve_, map_.available())) return;
  radius_cells_ = std::min(full_radius_cells_, radius_cells_ + kRegionSide_cells / 8);
}

bool RollingWindow::is_store_allowed() const {
  return frames_until_retry_ == 0 && pager_.free_buffers() > (config_.lockstep ? 0 : kBuffersForLoads);
}

bool RollingWindow::find_farthest(std::int64_t beyond_squared_cells, Target& found) {
  found.squared_cells = beyond_squared_cells;
  bool any = false;
  for (const RegionKey region : regions_.resident()) {
    const std::int64_t d = squared_distance_cells(region, camera_);
    if (d < found.squared_cells || (d == found.squared_cells && (!any || region > found.region))) continue;
    const RegionState& state = *regions_.find(region);
    if (state.busy || state.unreadable || needed_.holds(region)) continue;
    found = {region, d};
    any = true;
  }
  return any;
}

/// Pages out the farthest regions until `wanted` is free, or will be once they are stored.
bool RollingWindow::make_room(const MapCapacity& wanted) {
  Target farthest;
  while (!fits(wanted, map_.available() + leaving_)) {
    if (!is_store_allowed() || !find_farthest(-1, farthest) || !page_out(farthest.region)) return false;
    const auto distance_cells = static_cast<std::int64_t>(std::sqrt(static_cast<double>(farthest.squared_cells)));
    radius_cells_ = std::min(radius_cells_, distance_cells);
  }
  return true;
}

void RollingWindow::page_out_far() {
  Target farthest;
  for (std::uint32_t i = 0; i < config_.regions_per_frame && is_store_allowed(); ++i) {
    if (!find_farthest(radius_cells_ * radius_cells_ + 1, farthest) || !page_out(farthest.region)) return;
  }
}

bool RollingWindow::page_out(RegionKey region) {
  std::uint32_t index = 0;
  if (!pager_.try_acquire(index)) return false;
  PageBuffer& buffer = pager_[index];
  buffer.region = region;
  buffer.count = 0;
  buffer.freed = {0, 0, 0};
  for (BlockKey key = first_block(region); key < first_block(region + 1); ++key) {
    const std::uint32_t slot = map_.find(key);
    if (slot == kNoSlot) continue;
    const BlockHeader& header = map_.header(slot);
    ++buffer.freed.blocks;
    buffer.freed.planes += header.plane != kNoSlot ? 1 : 0;
    for (const std::uint32_t brick : header.bricks) buffer.freed.colour_bricks += brick != kNoSlot ? 1 : 0;
    StoredBlock& block = buffer.blocks[buffer.count];
    block.key = key;
    map_.read_stored_block(key, block.values);
    if (is_known(block.values)) ++buffer.count;  // nothing is lost with the others
  }
  RegionState& state = *regions_.find(region);
  state.touched = false;
  state.busy = true;
  leaving_ = leaving_ + buffer.freed;
  if (buffer.count == 0) {
    buffer.record = PageRecord{};
    on_stored(index, true);
    return true;
  }
  pager_.submit(PageJob::store, index);
  if (config_.lockstep) drain();
  return frames_until_retry_ == 0;
}

void RollingWindow::load_needed() {
  if (on_disk_count_ == 0) return;
  needed_.for_each([&](RegionKey region) {
    RegionState* state = regions_.find(region);
    if (state == nullptr || !state->on_disk || state->busy || state->unreadable) return;
    const MapCapacity needed = state->needed();
    if (!make_room(needed + reserve_) && !fits(needed, map_.available())) {
      ++counts_.no_room;
      return;
    }
    (void)load(region, *regions_.find(region));
  });
}

/// The nearest regions that may soon be seen, if there is room for them and for a frame.
void RollingWindow::load_ahead() {
  if (on_disk_count_ == 0) return;
  const std::int64_t limit_cells = std::min(ahead_cells_, radius_cells_ - kRegionSide_cells);
  if (limit_cells <= 0) return;
  const auto cells = static_cast<std::int32_t>(std::min<std::int64_t>(limit_cells, kAxisCells));
  const auto bound = [](std::int32_t k) { return std::clamp(k, 0, kAxisCells - 1); };
  const RegionBox ahead({bound(camera_.x - cells), bound(camera_.y - cells), bound(camera_.z - cells)},
                        {bound(camera_.x + cells), bound(camera_.y + cells), bound(camera_.z + cells)});
  constexpr std::size_t kMost = 16;
  std::array<Target, kMost> nearest;
  std::size_t count = 0;
  const std::size_t most = std::min<std::size_t>(config_.regions_per_frame, kMost);
  ahead.for_each([&](RegionKey region) {
    const RegionState* state = regions_.find(region);
    if (state == nullptr || !state->on_disk || state->busy || state->unreadable) return;
    const Target target{region, squared_distance_cells(region, camera_)};
    if (target.squared_cells > limit_cells * limit_cells) return;
    std::size_t place = count;
    while (place > 0 && nearest[place - 1].squared_cells > target.squared_cells) --place;
    if (place == most) return;
    count = std::min(count + 1, most);
    for (std::size_t i = count - 1; i > place; --i) nearest[i] = nearest[i - 1];
    nearest[place] = target;
  });
  for (std::size_t i = 0; i < count; ++i) {
    RegionState& state = *regions_.find(nearest[i].region);
    if (!fits(state.needed() + reserve_, map_.available()) || !load(nearest[i].region, state)) return;
  }
}

bool RollingWindow::load(RegionKey region, RegionState& state) {
  std::uint32_t index = 0;
  if (!pager_.try_acquire(index)) return false;
  pager_[index].region = region;
  state.busy = true;
  pager_.submit(PageJob::load, index);
  if (config_.lockstep) drain();
  return true;
}

void RollingWindow::take_results() {
  PageResult result;
  while (pager_.try_result(result)) handle(result);
}

void RollingWindow::drain() {
  PageResult result;
  while (pager_.under_way() > 0) {
    pager_.wait_result(result);
    handle(result);
  }
}

void RollingWindow::handle(const PageResult& result) {
  if (result.job == PageJob::store) {
    on_stored(result.buffer, result.ok);
  } else if (result.job == PageJob::load) {
    on_loaded(result.buffer, result.ok);
  } else {
    pager_.release(result.buffer);
  }
}

void RollingWindow::on_stored(std::uint32_t index, bool ok) {
  const PageBuffer& buffer = pager_[index];
  RegionState& state = *regions_.find(buffer.region);
  state.busy = false;
  leaving_ = leaving_ - buffer.freed;
  if (!ok) {
    ++counts_.failed_stores;
    frames_until_retry_ = kRetryFrames;
    pager_.release(index);
    return;
  }
  if (state.touched) {  // what was stored is no longer true
    ++counts_.taken_back;
    pager_.submit(PageJob::abandon, index);
    return;
  }
  for (BlockKey key = first_block(buffer.region); key < first_block(buffer.region + 1); ++key) map_.erase_block(key);
  if (buffer.count == 0) {
    regions_.remove_resident(buffer.region);
    pager_.release(index);
    return;
  }
  on_disk_count_ += state.on_disk ? 0 : 1;
  state.on_disk = true;
  state.blocks = buffer.record.blocks;
  state.planes = buffer.record.planes;
  state.colour_bricks = buffer.record.colour_bricks;
  ++counts_.regions_out;
  counts_.blocks_out += buffer.count;
  regions_.remove_resident(buffer.region);
  pager_.submit(PageJob::commit, index);
}

void RollingWindow::on_loaded(std::uint32_t index, bool ok) {
  const PageBuffer& buffer = pager_[index];
  RegionState* state = regions_.find(buffer.region);
  state->busy = false;
  if (!ok || !fits(state->needed(), map_.available())) {
    state->unreadable = !ok;
    ++(ok ? counts_.no_room : counts_.failed_loads);
    pager_.release(index);
    return;
  }
  add_blocks(map_, buffer.filled());
  ++counts_.regions_in;
  counts_.blocks_in += buffer.count;
  --on_disk_count_;
  state->on_disk = false;
  (void)regions_.add_resident(buffer.region);  // it has its place in the table already
  pager_.submit(PageJob::drop, index);
}

}  // namespace g3d::mapper
