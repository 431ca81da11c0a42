// SPDX-License-Identifier: Apache-2.0
// The frames that travel from the camera to the mapper: allocated once, then only their indices move. The camera thread
// takes a free one and fills it; the mapper thread gives it back. A frame that is dropped on the way travels on with
// its reason, or goes back through its own thread: only these two threads may touch the free list.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "hal/messages.hpp"
#include "hal/ring.hpp"

namespace g3d::hal {

/// A frame with storage for every pixel of `model`, all zero.
[[nodiscard]] Frame make_frame(const CameraModel& model);

class FramePool {
 public:
  FramePool(const CameraModel& model, std::size_t count);

  /// The frame's owner of the moment: camera after try_acquire, then whoever got the index through a ring.
  [[nodiscard]] Frame& operator[](std::uint32_t index) { return frames_[index]; }
  [[nodiscard]] const Frame& operator[](std::uint32_t index) const { return frames_[index]; }
  [[nodiscard]] std::size_t count() const { return free_.capacity(); }
  /// A snapshot, any thread.
  [[nodiscard]] std::size_t free_count() const { return free_.size(); }

  /// Camera thread. False if every frame is under way.
  [[nodiscard]] bool try_acquire(std::uint32_t& index) { return free_.try_pop(index); }
  /// Mapper thread, once for each acquired index.
  void release(std::uint32_t index);

 private:
  std::unique_ptr<Frame[]> frames_;
  Ring<std::uint32_t> free_;
};

}  // namespace g3d::hal
