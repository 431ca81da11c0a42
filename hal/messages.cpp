// SPDX-License-Identifier: Apache-2.0
// The names under which the report counts dropped frames.
#include "hal/messages.hpp"

namespace g3d::hal {

const char* to_string(DropReason reason) {
  switch (reason) {
    case DropReason::unreadable_depth:
      return "unreadable_depth";
    case DropReason::wrong_size:
      return "wrong_size";
    case DropReason::no_pose:
      return "no_pose";
    case DropReason::bad_pose:
      return "bad_pose";
    case DropReason::time_backwards:
      return "time_backwards";
    case DropReason::queue_full:
      return "queue_full";
    case DropReason::out_of_range:
      return "out_of_range";
    case DropReason::map_moving:
      return "map_moving";
    case DropReason::interrupted:
      return "interrupted";
    case DropReason::count_:
      break;
  }
  return "unknown";
}

}  // namespace g3d::hal
