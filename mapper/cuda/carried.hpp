// SPDX-License-Identifier: Apache-2.0
// What the executable carries for cards: the helper program and the kernels as PTX. Both are empty in a build that had
// no clang.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace g3d::mapper::cuda {

[[nodiscard]] std::span<const std::byte> carried_helper();
[[nodiscard]] std::string_view carried_kernels();

}  // namespace g3d::mapper::cuda
