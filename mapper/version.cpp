// SPDX-License-Identifier: Apache-2.0
// The only object that the build recompiles when the version changes.
#include "mapper/version.hpp"

namespace g3d::mapper {

const char* version() { return G3D_VERSION; }

}  // namespace g3d::mapper
