// SPDX-License-Identifier: Apache-2.0
// Which state of the sources this program was built from, as `git describe --always --dirty` says it.
#pragma once

namespace g3d::mapper {

[[nodiscard]] const char* version();

}  // namespace g3d::mapper
