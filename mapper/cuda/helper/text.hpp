// SPDX-License-Identifier: Apache-2.0
// Sentences in the shared memory, without the C++ library.
#pragma once

#include <cstddef>
#include <initializer_list>

namespace g3d::mapper::cuda {

/// As much of the three parts, one after the other, as there is room for; always ends with a zero.
inline void put_text(char* to, std::size_t room, const char* a, const char* b, const char* c) {
  std::size_t n = 0;
  for (const char* part : {a, b, c}) {
    for (; part != nullptr && *part != 0 && n + 1 < room; ++part) to[n++] = *part;
  }
  to[n] = 0;
}

}  // namespace g3d::mapper::cuda
