// SPDX-License-Identifier: Apache-2.0
// The fault matrix: seven kinds of fault x camera, odometry, serial line and disk, and what the whole robot has to do
// in each of the 28 cells. The first three are tested in tests/system/fault_matrix_test.cpp, the disk in
// tests/system/disk_faults_test.cpp.
#pragma once

#include <cstdint>

namespace g3d::test {

enum class Safe : std::uint8_t {
  stands,       ///< within the deadline
  drives,       ///< the fault does not matter enough: it drives on and touches nothing
  out_of_reach  ///< nobody can tell the base, which keeps its last command: zeros once the line is back
};
enum class After : std::uint8_t { goes_on, waits };

struct FaultCell {
  const char* fault;
  Safe safe;
  double notices_s;  ///< from the fault to zeros at the wheels; the body's braking comes on top
  double creep_m;    ///< what it may move after that while the fault lasts: in tries, and while a loose contact holds
  After after;
};

inline constexpr double kAnyway_m = 1e9;

// Camera: an image must not be older than 0.35 s, and comes each 0.1 s; an image that stands still is seen once the
// base has moved by 3 cm. Line: 45 ms without a packet, then a tick; 80 ms and the way back where it is late. Odometry:
// driven wheels that do not count for 0.2 s (one alone: 0.5 s).
inline constexpr FaultCell kFaultCells[] = {
    {"camera:off", Safe::stands, 0.48, 0.0, After::goes_on},
    {"camera:stuck", Safe::stands, 0.56, 0.0, After::goes_on},
    {"camera:garbage", Safe::stands, 0.48, 0.0, After::goes_on},
    // It looks as if the floor were lower: the robot turns, but does not drive over what it takes for an edge. On what
    // it saw before, it brakes late: half of the way that it could go in that time.
    {"camera:wrong", Safe::drives, 0.0, 1.5, After::goes_on},
    {"camera:slow", Safe::stands, 0.56, 0.2, After::goes_on},
    {"camera:delayed", Safe::stands, 0.48, 0.0, After::goes_on},
    {"camera:intermittent", Safe::stands, 0.48, 1.0, After::goes_on},
    {"odometry:off", Safe::stands, 0.30, 0.2, After::goes_on},
    {"odometry:stuck", Safe::stands, 0.07, 0.0, After::goes_on},
    {"odometry:garbage", Safe::stands, 0.07, 0.0, After::goes_on},
    // Only its ticks can prove the wheel well, and without odometry it may not try: somebody must push it.
    {"odometry:wrong", Safe::stands, 0.60, 0.0, After::waits},
    {"odometry:slow", Safe::stands, 0.10, 0.0, After::goes_on},
    {"odometry:delayed", Safe::stands, 0.10, 0.0, After::goes_on},
    {"odometry:intermittent", Safe::stands, 0.30, 1.0, After::goes_on},
    {"line:off", Safe::out_of_reach, 0.07, 0.0, After::goes_on},
    {"line:stuck", Safe::stands, 0.07, 0.0, After::goes_on},
    {"line:garbage", Safe::stands, 0.30, 0.1, After::goes_on},
    {"line:wrong", Safe::drives, 0.0, 3.0, After::goes_on},
    {"line:slow", Safe::stands, 0.10, 0.0, After::goes_on},
    {"line:delayed", Safe::stands, 0.25, 0.0, After::goes_on},
    {"line:intermittent", Safe::drives, 0.0, 2.0, After::goes_on},
    // The robot needs no disk to drive. A recording that is written all along has a gap; all else waits in memory.
    {"disk:off", Safe::drives, 0.0, kAnyway_m, After::goes_on},
    {"disk:stuck", Safe::drives, 0.0, kAnyway_m, After::goes_on},
    {"disk:garbage", Safe::drives, 0.0, kAnyway_m, After::goes_on},
    {"disk:wrong", Safe::drives, 0.0, kAnyway_m, After::goes_on},
    {"disk:slow", Safe::drives, 0.0, kAnyway_m, After::goes_on},
    {"disk:delayed", Safe::drives, 0.0, kAnyway_m, After::goes_on},
    {"disk:intermittent", Safe::drives, 0.0, kAnyway_m, After::goes_on},
};

}  // namespace g3d::test
