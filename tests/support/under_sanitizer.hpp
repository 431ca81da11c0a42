// SPDX-License-Identifier: Apache-2.0
// Whether this program has a sanitizer in it: its memory is not the system's then, and mlockall() does nothing.
#pragma once

extern "C" __attribute__((weak)) void __asan_init();
extern "C" __attribute__((weak)) void __tsan_init();

namespace g3d::test {

[[nodiscard]] inline bool is_under_sanitizer() { return &__asan_init != nullptr || &__tsan_init != nullptr; }

}  // namespace g3d::test
