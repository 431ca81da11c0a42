// SPDX-License-Identifier: Apache-2.0
// A stream confined to a few of the card's multiprocessors, to learn what the kernels would take on a smaller card. It
// is the driver's "green context" (CUDA 12.5 and later); the ordinary context stays current, for what is launched into
// the stream is confined by the stream alone.
#pragma once

#include "mapper/cuda/helper/driver.hpp"
#include "mapper/cuda/helper_protocol.hpp"

namespace g3d::mapper::cuda {

/// As cuda.h has it: CUdevResource, for multiprocessors. Only the driver writes there.
struct CuResource {
  int type;
  unsigned char internal[92];
  unsigned processors;
  unsigned char others[44];
};
static_assert(sizeof(CuResource) == 144 && offsetof(CuResource, processors) == 96);

/// Takes the smallest share of the card that has control.wanted_processors, and makes a stream that keeps to it. False:
/// control.note says why the whole card is used.
[[nodiscard]] bool confine(const Driver& driver, int device, HelperControl& control, CuHandle& stream,
                           unsigned& processors);

}  // namespace g3d::mapper::cuda
