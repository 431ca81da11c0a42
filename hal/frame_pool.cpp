// SPDX-License-Identifier: Apache-2.0
#include "hal/frame_pool.hpp"

#include <cassert>

namespace g3d::hal {

Frame make_frame(const CameraModel& model) {
  Frame frame;
  // Zeroed, so that the pages are there before the first frame comes.
  frame.depth = std::make_unique<std::uint16_t[]>(model.pixel_count());
  frame.rgb = std::make_unique<std::uint8_t[]>(3 * model.pixel_count());
  return frame;
}

FramePool::FramePool(const CameraModel& model, std::size_t count)
    : frames_(std::make_unique<Frame[]>(count)), free_(count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    frames_[i] = make_frame(model);
    release(i);
  }
}

void FramePool::release(std::uint32_t index) {
  assert(index < count() && "index of another pool");
  [[maybe_unused]] const bool taken = free_.try_push(index);
  assert(taken && "a frame was released twice");
}

}  // namespace g3d::hal
