// SPDX-License-Identifier: Apache-2.0
// A Kinect that is none: an OpenNI2 driver whose device shows what a source of frames shows (the simulated camera), so
// that everything above the driver is used as with a real one. There is one socket per process; what is plugged into it
// is found the next time that the driver starts, and can be pulled out, made silent, and made to send half images.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "hal/clock.hpp"
#include "hal/messages.hpp"

namespace g3d::hal::kinect::openni {

struct VirtualKinectOptions {
  double rate_hz = 30.0;
  bool is_registered = true;                ///< whether it can register depth to colour
  std::uint64_t first_tick_us = 1'000'000;  ///< its own clock's beginning
};

class VirtualKinect {
 public:
  /// Fills a 640 x 480 frame, depth in millimetres, for the image of that number. The device's thread. False: the
  /// device skips that image.
  using Show = std::function<bool(std::uint64_t number, Frame& out)>;

  /// The socket must be free. `clock` outlives this.
  VirtualKinect(Show show, Clock& clock, const VirtualKinectOptions& options = {});
  /// Pulls it out.
  ~VirtualKinect();
  VirtualKinect(const VirtualKinect&) = delete;
  VirtualKinect& operator=(const VirtualKinect&) = delete;

  // Any thread.
  void plug_in();
  void pull_out();
  /// It stays there and sends nothing.
  void set_silent(bool is_silent);
  /// The next depth images lack their lower half.
  void send_half(int count);
  /// Depth images that were sent since it was made.
  [[nodiscard]] std::uint64_t sent() const;

  struct State;

 private:
  std::shared_ptr<State> state_;
};

}  // namespace g3d::hal::kinect::openni
