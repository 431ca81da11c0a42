// SPDX-License-Identifier: Apache-2.0
// What a virtual Kinect shows: a few images that the simulated camera took of a furnished room, one after the other.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/messages.hpp"

namespace g3d::test {

class ShownFrames {
 public:
  /// 640 x 480, millimetres.
  explicit ShownFrames(std::size_t count = 4);
  /// The image of that number into `out`.
  void show(std::uint64_t number, hal::Frame& out) const;
  [[nodiscard]] const hal::Frame& frame(std::uint64_t number) const { return frames_[number % frames_.size()]; }
  /// Whether depth and, if it has one, colour are those of that number.
  [[nodiscard]] bool is_frame(std::uint64_t number, const hal::Frame& frame) const;

 private:
  std::vector<hal::Frame> frames_;
};

}  // namespace g3d::test
