// SPDX-License-Identifier: Apache-2.0
// Room for the heap in large pages, asked for once at start. A robot makes some hundred arrays of a megabyte or four
// before its first frame, and a page fault for every 4 kB of them is most of its start on a small core.
#pragma once

#include <cstddef>

namespace g3d::hal {

/// Grows the heap by so many bytes at once and asks for large pages there; what the calling thread and those without an
/// arena of their own allocate later, up to 32 MB a piece, comes from it, and nothing of it goes back to the system.
/// Address space only: pages come when they are touched. Where the kernel has no large pages, everything works as
/// before. For the main thread, before others are started. False: there is not so much address space (or another
/// allocator, as a sanitizer's).
bool make_heap_room(std::size_t bytes);

}  // namespace g3d::hal
