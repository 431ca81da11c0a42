// SPDX-License-Identifier: Apache-2.0
// Saves the map while it is being mapped, so that a power cut costs the last minute and not the whole walk. Blocks are
// copied one by one under their sequence lock and the copy is written as `map.g3d`: each block is whole, neighbours may
// be a frame or two apart. The mapper never waits for this; the copy doubles the map's memory while a save is under
// way.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "mapper/files/map_file.hpp"

namespace g3d::mapper {

/// A copy of its own, made by any thread while the writer works. Its pools are address space until they are touched.
/// nullptr if there is not enough memory.
[[nodiscard]] std::unique_ptr<VoxelMap> snapshot_of(const VoxelMap& map);

/// Any thread, while the writer works. What appears or goes away meanwhile is in the file or not.
[[nodiscard]] hal::Result<SaveReport> save_snapshot(const VoxelMap& map, const MapFileMeta& meta,
                                                    const std::string& path);

struct CheckpointConfig {
  double period_s = 60.0;  ///< from the end of one save to the start of the next
  std::string path;
  MapFileMeta meta;
};

/// A thread of its own, at low priority, from construction on. The map outlives it.
class Checkpoint {
 public:
  Checkpoint(const VoxelMap& map, CheckpointConfig config);
  ~Checkpoint() { stop(); }
  Checkpoint(const Checkpoint&) = delete;
  Checkpoint& operator=(const Checkpoint&) = delete;

  /// Returns once a save under way is complete. Afterwards nobody but the caller writes the file.
  void stop();

  // After stop()
  [[nodiscard]] int saves() const { return saves_; }
  [[nodiscard]] int failed_saves() const { return failed_saves_; }
  /// Of the first save that failed; the later ones were tried all the same. Empty if none did.
  [[nodiscard]] const std::string& first_error() const { return first_error_; }

 private:
  void loop();
  void save();

  const VoxelMap& map_;
  const CheckpointConfig config_;
  std::mutex mutex_;
  std::condition_variable stop_changed_;
  bool stop_ = false;  // under mutex_
  int saves_ = 0;      // these three: the thread's, then the caller's
  int failed_saves_ = 0;
  std::string first_error_;
  std::thread thread_;
};

}  // namespace g3d::mapper
