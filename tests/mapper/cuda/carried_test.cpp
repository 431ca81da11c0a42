// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/carried.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <string>

using namespace g3d::mapper::cuda;

TEST_CASE("the executable carries a helper program and kernels that a TX2's driver accepts") {
  const auto helper = carried_helper();
  REQUIRE(helper.size() > 4096);
  CHECK(std::memcmp(helper.data(),
                    "\x7F"
                    "ELF",
                    4) == 0);
  const std::string_view kernels = carried_kernels();
  REQUIRE_FALSE(kernels.empty());  // tests are built where clang is
  // CUDA 10.2 knows PTX up to 6.5 and runs what was made for sm_62 or older.
  CHECK(kernels.find(".version 6.3\n") != std::string_view::npos);
  CHECK(kernels.find(".target sm_62\n") != std::string_view::npos);
  CHECK(kernels.find(".address_size 64\n") != std::string_view::npos);
  for (const char* name :
       {"import_blocks_kernel", "read_image_kernel", "walk_image_kernel", "find_work_kernel", "update_map_1_kernel",
        "update_map_4_kernel", "export_classes_kernel", "export_blocks_kernel"}) {
    CHECK(kernels.find(std::string(".visible .entry ") + name + "(") != std::string_view::npos);
  }
}

TEST_CASE("the kernels need nothing from elsewhere, and are small enough to be compiled when a robot starts") {
  const std::string_view kernels = carried_kernels();
  CHECK(kernels.find(".extern") == std::string_view::npos);
  CHECK(kernels.find("call") == std::string_view::npos);  // all is inlined: no stack, no library
  CHECK(kernels.find(".version", kernels.find(".version") + 1) == std::string_view::npos);
  CHECK(kernels.size() < (std::size_t{1} << 20));
}

TEST_CASE("no kernel fuses or approximates, so that both twins round alike") {
  const std::string_view kernels = carried_kernels();
  for (const char* forbidden : {"fma.", "mad.f32", ".approx", ".ftz", "\tmul.f32", "\tadd.f32", "\tsub.f32", ".f64"}) {
    INFO(forbidden);
    CHECK(kernels.find(forbidden) == std::string_view::npos);
  }
}
