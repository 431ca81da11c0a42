// SPDX-License-Identifier: Apache-2.0
// The fuzzer's way into all readers of outside data, linked into one program. The name that it is called by says which
// of them it gives its inputs to: the build links it to as many names as there are *_fuzz.cpp. Each of these is
// compiled with the name of its file instead of LLVMFuzzerTestOneInput.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#define FUZZ_TARGET(name) extern "C" int name(const std::uint8_t* data, std::size_t size_bytes);
#include "targets.inc"
#undef FUZZ_TARGET

namespace {

using Target = int (*)(const std::uint8_t* data, std::size_t size_bytes);

struct NamedTarget {
  std::string_view name;
  Target target;
};

#define FUZZ_TARGET(name) {#name, name},
constexpr NamedTarget kTargets[] = {
#include "targets.inc"
};
#undef FUZZ_TARGET

Target target = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char*** argv) {
  std::string_view name((*argv)[0]);
  name.remove_prefix(name.find_last_of('/') + 1);  // npos + 1 is 0: no folder
  for (const NamedTarget& each : kTargets) {
    if (each.name == name) target = each.target;
  }
  if (target != nullptr) return 0;
  std::fprintf(stderr, "%s is none of those that can be fuzzed. Call this program by one of these names:\n",
               (*argv)[0]);
  for (const NamedTarget& each : kTargets) std::fprintf(stderr, "  %s\n", each.name.data());
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  return target(data, size_bytes);
}
