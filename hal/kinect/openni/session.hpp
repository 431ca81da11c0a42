// SPDX-License-Identifier: Apache-2.0
// OpenNI2 is one per process: who holds the session has it to himself, with one driver. Images of all its streams go to
// the holder's tap from the moment that a stream is started.
#pragma once

#include <memory>
#include <string>

#include "hal/kinect/openni/driver_table.hpp"
#include "hal/result.hpp"

namespace g3d::hal::kinect::openni {

class Session {
 public:
  /// `clock` stamps what arrives. Both outlive the session. Errors: no_capacity (somebody holds it), unsupported (the
  /// driver could not start: without USB, for one).
  [[nodiscard]] static Result<std::unique_ptr<Session>> begin(Driver driver, ImageSink& tap, const Clock& clock);
  /// Devices and streams must have been closed.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// The tap is not called any more when this returns.
  static void end_tap() { set_image_tap(nullptr, nullptr); }

 private:
  Session() = default;
};

/// What OpenNI2 says about its last failure, in one line.
[[nodiscard]] std::string openni_error();

}  // namespace g3d::hal::kinect::openni
