// SPDX-License-Identifier: Apache-2.0
// A mapper put together by hand around one way of finding free space, so that this and the kernels can be chosen.
#pragma once

#include <string>

#include "mapper/cpu/free_space.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/workload.hpp"

namespace g3d::test {

/// Hash of the map after all frames; a text that is none if a frame lies outside of the grid. `free_space` must have
/// been made for the same camera and resolution.
[[nodiscard]] std::string hash_of_run(mapper::cpu::FreeSpace& free_space, const mapper::cpu::Kernels& kernels,
                                      const mapper::MapperConfig& config, const Workload& work);

}  // namespace g3d::test
