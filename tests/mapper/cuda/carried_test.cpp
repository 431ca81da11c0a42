// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/carried.hpp"

#include <elf.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <string>

using namespace g3d::mapper::cuda;

namespace {

/// Bytes of the helper's table of constructors.
std::size_t constructor_bytes(std::span<const std::byte> program) {
  Elf64_Ehdr file;
  REQUIRE(program.size() > sizeof file);
  std::memcpy(&file, program.data(), sizeof file);
  REQUIRE(file.e_shnum > 0);
  REQUIRE(file.e_shoff + file.e_shnum * sizeof(Elf64_Shdr) <= program.size());
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < file.e_shnum; ++i) {
    Elf64_Shdr section;
    std::memcpy(&section, program.data() + file.e_shoff + i * sizeof section, sizeof section);
    if (section.sh_type == SHT_INIT_ARRAY) bytes += section.sh_size;
  }
  return bytes;
}

}  // namespace

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
        "update_map_4_kernel", "export_classes_kernel", "export_blocks_kernel", "read_columns_kernel",
        "cast_rays_kernel", "mark_looks_kernel", "count_looks_kernel", "begin_spread_kernel", "spread_round_kernel"}) {
    CHECK(kernels.find(std::string(".visible .entry ") + name + "(") != std::string_view::npos);
  }
}

TEST_CASE("the helper program starts on a system with a C library as old as the first for its processor") {
  const auto helper = carried_helper();
  const std::string_view text(reinterpret_cast<const char*>(helper.data()), helper.size());
  constexpr std::string_view kName = "GLIBC_";
  std::size_t versions = 0;
  for (std::size_t at = text.find(kName); at != std::string_view::npos; at = text.find(kName, at + 1)) {
    const std::string version(text.data() + at + kName.size());
    INFO(version);
    CHECK((version == "2.2.5" || version == "2.17"));  // x86-64, aarch64
    ++versions;
  }
  CHECK(versions > 0);
  CHECK(text.find("libstdc++") == std::string_view::npos);
  CHECK(text.find("libgcc") == std::string_view::npos);
  // The compiler's own (it registers nothing) may be left out, anybody else's not: old systems would not run it.
  CHECK(constructor_bytes(helper) <= sizeof(void*));
}

TEST_CASE("the kernels need nothing from elsewhere, and are small enough to be compiled when a robot starts") {
  const std::string_view kernels = carried_kernels();
  CHECK(kernels.find(".visible .entry export_classes_kernel(") != std::string_view::npos);
  CHECK(kernels.find(".extern") == std::string_view::npos);
  CHECK(kernels.find("call") == std::string_view::npos);  // all is inlined: no stack, no library
  CHECK(kernels.find(".version", kernels.find(".version") + 1) == std::string_view::npos);
  CHECK(kernels.size() < (std::size_t{1} << 20));
}

TEST_CASE("no kernel fuses or approximates, so that both twins round alike") {
  const std::string_view kernels = carried_kernels();
  for (const char* forbidden : {"fma.", "mad.f32", ".approx", ".ftz", "\tmul.f32", "\tadd.f32", "\tsub.f32",
                                "\tmul.f64", "\tadd.f64", "\tsub.f64"}) {
    INFO(forbidden);
    CHECK(kernels.find(forbidden) == std::string_view::npos);
  }
}

TEST_CASE("only what solves for a pose computes in double precision, by one thread: robots' cards are slow at it") {
  const std::string_view kernels = carried_kernels();
  constexpr std::string_view kEntry = ".visible .entry ";
  int others = 0;
  for (std::size_t at = kernels.find(kEntry); at != std::string_view::npos;) {
    const std::size_t next = kernels.find(kEntry, at + kEntry.size());
    const std::string_view kernel = kernels.substr(at, next - at);
    const std::string_view name = kernel.substr(kEntry.size(), kernel.find('(') - kEntry.size());
    const bool solves = name == "match_step_kernel" || name == "read_tiles_kernel";
    INFO(name);
    CHECK((kernel.find(".f64") != std::string_view::npos) == solves);
    others += solves ? 0 : 1;
    at = next;
  }
  CHECK(others > 20);
}
