// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/checkpoint.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <utility>

namespace g3d::mapper {
namespace {

// Of the scheduler's -20 .. 19: with one core left, the mapper's threads go first.
constexpr int kNice = 10;

}  // namespace

std::unique_ptr<VoxelMap> snapshot_of(const VoxelMap& map) {
  try {
    auto copy = std::make_unique<VoxelMap>(map.grid(), map.capacity());
    BlockKey key = 0;
    BlockValues values;
    const std::uint32_t end = map.slot_end();
    for (std::uint32_t slot = 0; slot < end; ++slot) {
      if (map.copy_block(slot, key, values) && !copy->write_block(key, values)) return nullptr;
    }
    return copy;
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

hal::Result<SaveReport> save_snapshot(const VoxelMap& map, const MapFileMeta& meta, const std::string& path) {
  const hal::Error no_memory{hal::Reason::no_capacity,
                             fmt::format("{}: no memory for a copy of the map while it grows; the next save tries "
                                         "again, a smaller --memory leaves more room",
                                         path)};
  const std::unique_ptr<VoxelMap> copy = snapshot_of(map);
  if (copy == nullptr) return no_memory;
  try {
    return save_map(*copy, meta, path);
  } catch (const std::bad_alloc&) {
    return no_memory;
  }
}

Checkpoint::Checkpoint(const VoxelMap& map, CheckpointConfig config)
    : map_(map), config_(std::move(config)), thread_([this] { loop(); }) {}

void Checkpoint::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  stop_changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Checkpoint::loop() {
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  const std::chrono::duration<double> period(std::clamp(config_.period_s, 0.001, 1e6));
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      if (stop_changed_.wait_for(lock, period, [this] { return stop_; })) return;
    }
    save();
  }
}

void Checkpoint::save() {
  if (const auto saved = save_snapshot(map_, config_.meta, config_.path); saved) {
    ++saves_;
  } else if (++failed_saves_ == 1) {
    first_error_ = saved.error().text;
  }
}

}  // namespace g3d::mapper
