// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <set>
#include <string>

#include "mapper/cpu/kernels/kernels.hpp"

using namespace g3d::mapper::cpu;

namespace {

/// What the system says about its first processor; empty on machines that are no amd64.
std::set<std::string> processor_flags() {
  std::ifstream file("/proc/cpuinfo");
  std::string word;
  while (file >> word && word != "flags") {
  }
  std::set<std::string> flags;
  std::string line;
  std::getline(file, line);
  std::size_t begin = 0;
  while (begin < line.size()) {
    const std::size_t end = std::min(line.find(' ', begin), line.size());
    flags.insert(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return flags;
}

bool has_all(const std::set<std::string>& flags, const std::set<std::string>& needed) {
  return std::includes(flags.begin(), flags.end(), needed.begin(), needed.end());
}

}  // namespace

TEST_CASE("the best kernels are those of the newest instruction set that the processor has") {
  const std::set<std::string> flags = processor_flags();
  const bool avx2 = has_all(flags, {"avx2", "bmi1", "bmi2", "popcnt", "f16c"});
  const bool avx512 = avx2 && has_all(flags, {"avx512f", "avx512bw", "avx512dq", "avx512vl"});
  CHECK(std::string(best_kernels().name) == (avx512 ? "avx512" : avx2 ? "avx2" : "baseline"));
  CHECK(std::string(kernels_by_name("avx512").name) == (avx512 ? "avx512" : "baseline"));
  CHECK(std::string(kernels_by_name("avx2").name) == (avx2 ? "avx2" : "baseline"));
}
