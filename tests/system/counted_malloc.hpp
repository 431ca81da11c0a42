// SPDX-License-Identifier: Apache-2.0
// The system tests' own malloc counts calls of a thread that has armed itself; see allocation_test.cpp.
#pragma once

#include <atomic>
#include <cstdint>

namespace g3d::test {

extern std::atomic<std::uint64_t> allocations;
extern thread_local bool this_thread_armed;

}  // namespace g3d::test
