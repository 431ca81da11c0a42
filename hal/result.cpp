// SPDX-License-Identifier: Apache-2.0
#include "hal/result.hpp"

namespace g3d::hal {

const char* to_string(Reason reason) {
  switch (reason) {
    case Reason::not_found:
      return "not_found";
    case Reason::no_permission:
      return "no_permission";
    case Reason::io_error:
      return "io_error";
    case Reason::disk_full:
      return "disk_full";
    case Reason::truncated:
      return "truncated";
    case Reason::malformed:
      return "malformed";
    case Reason::bad_checksum:
      return "bad_checksum";
    case Reason::out_of_range:
      return "out_of_range";
    case Reason::unsupported:
      return "unsupported";
    case Reason::too_large:
      return "too_large";
    case Reason::no_capacity:
      return "no_capacity";
    case Reason::bad_usage:
      return "bad_usage";
  }
  return "unknown";
}

}  // namespace g3d::hal
