// SPDX-License-Identifier: Apache-2.0
// What holds for every pick, also where there is only one variant.
#include <catch2/catch.hpp>
#include <string>

#include "mapper/cpu/kernels/kernels.hpp"

using namespace g3d::mapper::cpu;

TEST_CASE("the baseline is always there, and names that nobody knows give it") {
  CHECK(std::string(kernels_by_name("baseline").name) == "baseline");
  CHECK(&kernels_by_name("no such thing") == &kernels_by_name("baseline"));
  CHECK(&kernels_by_name("") == &kernels_by_name("baseline"));
  CHECK(&kernels_by_name(best_kernels().name) == &best_kernels());
}

TEST_CASE("no variant leaves a kernel out") {
  for (const char* name : {"baseline", "avx2", "avx512"}) {
    const Kernels& k = kernels_by_name(name);
    CHECK(k.classify_row != nullptr);
    CHECK(k.carry_down != nullptr);
    CHECK(k.bound_up != nullptr);
    CHECK(k.unproject_row != nullptr);
    CHECK(k.max_filter_row != nullptr);
    CHECK(k.halve_max_row != nullptr);
    CHECK(k.halve_min_row != nullptr);
    CHECK(k.bound_boxes != nullptr);
    CHECK(k.project_brick != nullptr);
    CHECK(k.apply_block != nullptr);
    CHECK(k.any_contested != nullptr);
    CHECK(k.walk_rays != nullptr);
    CHECK(k.walk_bresenham != nullptr);
  }
}
