// SPDX-License-Identifier: Apache-2.0
// OpenNI2's drivers in a static program: what would be shared objects in a folder is a table here, which the core asks
// instead of the loader (scripts/third_party/openni2). On the way every call is guarded: an exception out of a driver
// (libfreenect's throws out of its constructor where USB cannot start) becomes an error, or the process would end. And
// every frame can be seen in the driver's own thread, before the core, which keeps one frame per stream and loses it if
// its reader comes late.
#pragma once

#include <cstdint>
#include <string>

#include "hal/clock.hpp"
#include "hal/kinect/sensor_link.hpp"

namespace g3d::hal::kinect::openni {

enum class Driver : std::uint8_t { oni_file, freenect, virtual_kinect, count_ };

/// Which one the core will find when it is started next.
void select_driver(Driver driver);

/// Calls that a driver ended by an exception, and what the last one said; since the process began.
[[nodiscard]] std::uint64_t driver_exceptions();
[[nodiscard]] std::string last_driver_exception();

/// From now on depth and colour images go to `tap` in the thread of their driver, with their arrival by `clock`; depth
/// that is not in millimetres and colour that is not RGB as of no known format. nullptr: no more; returns when no
/// thread is in the one before.
void set_image_tap(ImageSink* tap, const Clock* clock);

}  // namespace g3d::hal::kinect::openni
