// SPDX-License-Identifier: Apache-2.0
// A driver without a card, for tests: the functions that the helper process uses, over this processor's memory, with
// kernels run one block after another in random order. Built as libcuda.so.1 beside the unit tests.
#include "mapper/cuda/target_host.hpp"
//
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "mapper/cuda/helper/few_processors.hpp"
#include "mapper/cuda/kernels/launches.hpp"

using namespace g3d::mapper::cuda;

namespace {

constexpr int kOutOfMemory = 2;
constexpr int kInvalidPtx = 218;
constexpr int kNotFound = 500;
constexpr std::string_view kKernels[] = {
    "import_blocks_kernel", "read_image_kernel",   "walk_image_kernel",     "find_work_kernel",
    "update_map_1_kernel",  "update_map_4_kernel", "export_classes_kernel", "export_blocks_kernel",
    "read_columns_kernel",  "cast_rays_kernel",    "mark_looks_kernel",     "count_looks_kernel",
    "begin_spread_kernel",  "spread_round_kernel", "read_tiles_kernel",     "find_samples_kernel",
    "count_chosen_kernel",  "choose_kernel",       "match_step_kernel",     "place_samples_kernel",
    "lead_cells_kernel",    "add_samples_kernel",  "sweep_cells_kernel",    "export_cells_kernel",
    "import_cells_kernel"};
Memory memory_map{};
FrameParams frame_params{};
std::uint64_t random_bits = 0x9E3779B97F4A7C15ULL;
char handles[32];

CuHandle handle(std::size_t number) { return reinterpret_cast<CuHandle>(handles + number); }
void* host(CuDevicePointer p) { return reinterpret_cast<void*>(p); }

void shuffle(std::vector<int>& order) {
  for (std::size_t i = order.size(); i > 1; --i) {
    random_bits ^= random_bits << 13;
    random_bits ^= random_bits >> 7;
    random_bits ^= random_bits << 17;
    std::swap(order[i - 1], order[(random_bits >> 16) % i]);
  }
}

template <typename T>
T argument(void** arguments, int index) {
  return *static_cast<T*>(arguments[index]);
}

void run(std::size_t kernel, const Block& block, void** arguments) {
  const Memory& m = memory_map;
  if (kernel == 0) import_blocks(block, m, argument<Parcels>(arguments, 0), argument<std::uint32_t>(arguments, 1));
  if (kernel == 1) read_image(block, m, frame_params);
  if (kernel == 2) walk_image(block, m, frame_params);
  if (kernel == 3) find_work(block, m, frame_params);
  if (kernel == 4) update_map<1>(block, m, frame_params);
  if (kernel == 5) update_map<4>(block, m, frame_params);
  if (kernel == 6) {
    export_classes(block, m, frame_params, argument<Classes>(arguments, 0), argument<FrameCounters*>(arguments, 1),
                   argument<std::uint32_t>(arguments, 2));
  }
  if (kernel == 7) {
    export_blocks(block, m, argument<Parcels>(arguments, 0), argument<std::uint32_t>(arguments, 1),
                  argument<std::uint32_t>(arguments, 2));
  }
  if (kernel == 8) {
    read_columns(block, m, argument<std::uint32_t>(arguments, 0), argument<std::uint32_t>(arguments, 1));
  }
  if (kernel == 9) cast_rays(block, m, argument<float>(arguments, 0), argument<std::uint32_t>(arguments, 1));
  if (kernel == 10) {
    mark_looks(block, m, argument<g3d::mapper::LookModel>(arguments, 0), argument<std::uint32_t>(arguments, 1));
  }
  if (kernel == 11) count_looks(block, m, argument<std::uint32_t>(arguments, 0));
  if (kernel == 12) begin_spread(block, m);
  if (kernel == 13) spread_round(block, m, argument<std::uint32_t>(arguments, 0));
  if (kernel == 14) read_tiles(block, m);
  if (kernel == 15) find_samples(block, m);
  if (kernel == 16) count_chosen(block, m);
  if (kernel == 17) choose(block, m);
  if (kernel == 18) match_step(block, m, argument<int>(arguments, 0));
  if (kernel == 19) place_samples(block, m);
  if (kernel == 20) lead_cells(block, m);
  if (kernel == 21) add_samples(block, m);
  if (kernel == 22) sweep_cells(block, m);
  if (kernel == 23) export_cells(block, m, argument<std::uint32_t>(arguments, 0));
  if (kernel == 24) {
    import_cells(block, m, argument<std::uint32_t>(arguments, 0), argument<std::uint32_t>(arguments, 1));
  }
}

constexpr int kNotSupported = 801;
constexpr int kProcessors = 2;
bool confined = false;  // there is a stream that keeps to fewer multiprocessors, and everything must go there

bool cannot_map() { return std::getenv("FAKE_CUDA_CANNOT_MAP") != nullptr; }

}  // namespace

extern "C" {

int cuInit(unsigned) { return 0; }
int cuDeviceGet(int* device, int) { return *device = 0; }
int cuDeviceGetName(char* name, int room, int) {
  std::strncpy(name, "a card that is none", static_cast<std::size_t>(room));
  return 0;
}
int cuDeviceGetAttribute(int* value, int, int) {
  *value = kProcessors;
  return 0;
}
int cuDevicePrimaryCtxRetain(CuHandle* context, int) {
  *context = handle(0);
  return 0;
}
int cuDevicePrimaryCtxSetFlags(int, unsigned) { return 0; }
int cuCtxSetCurrent(CuHandle) { return 0; }
int cuModuleLoadDataEx(CuHandle* module, const void* text, unsigned, int*, void**) {
  *module = handle(1);
  const std::string_view ptx = static_cast<const char*>(text);
  return ptx.find(".version 6.") != std::string_view::npos && ptx.find(".target sm_62") != std::string_view::npos
             ? 0
             : kInvalidPtx;
}
int cuModuleGetFunction(CuHandle* function, CuHandle, const char* name) {
  const auto* found = std::find(std::begin(kKernels), std::end(kKernels), name);
  *function = handle(static_cast<std::size_t>(found - std::begin(kKernels)));
  return found == std::end(kKernels) ? kNotFound : 0;
}
int cuModuleGetGlobal_v2(CuDevicePointer* pointer, std::size_t* bytes, CuHandle, const char* name) {
  const bool is_map = std::string_view(name) == "memory_map";
  *pointer = is_map ? reinterpret_cast<CuDevicePointer>(&memory_map) : reinterpret_cast<CuDevicePointer>(&frame_params);
  *bytes = is_map ? sizeof memory_map : sizeof frame_params;
  return is_map || std::string_view(name) == "frame_params" ? 0 : kNotFound;
}
int cuMemAlloc_v2(CuDevicePointer* pointer, std::size_t bytes) {
  const char* most = std::getenv("FAKE_CUDA_BYTES");
  if (most != nullptr && bytes > std::strtoull(most, nullptr, 10)) return kOutOfMemory;
  *pointer = reinterpret_cast<CuDevicePointer>(std::aligned_alloc(256, (bytes + 255) / 256 * 256));
  return *pointer == 0 ? kOutOfMemory : 0;
}
int cuMemsetD8_v2(CuDevicePointer to, unsigned char value, std::size_t bytes) {
  std::memset(host(to), value, bytes);
  return 0;
}
int cuMemcpyHtoD_v2(CuDevicePointer to, const void* from, std::size_t bytes) {
  std::memcpy(host(to), from, bytes);
  return 0;
}
int cuMemcpyHtoDAsync_v2(CuDevicePointer to, const void* from, std::size_t bytes, CuHandle) {
  return cuMemcpyHtoD_v2(to, from, bytes);
}
int cuMemcpyDtoH_v2(void* to, CuDevicePointer from, std::size_t bytes) {
  std::memcpy(to, host(from), bytes);
  return 0;
}
int cuMemcpyDtoHAsync_v2(void* to, CuDevicePointer from, std::size_t bytes, CuHandle) {
  return cuMemcpyDtoH_v2(to, from, bytes);
}
int cuMemHostRegister_v2(void*, std::size_t, unsigned) { return cannot_map() ? kNotFound : 0; }
int cuMemHostGetDevicePointer_v2(CuDevicePointer* pointer, void* place, unsigned) {
  *pointer = reinterpret_cast<CuDevicePointer>(place);
  return 0;
}
int cuStreamCreate(CuHandle* stream, unsigned) {
  *stream = handle(2);
  return 0;
}
int cuStreamSynchronize(CuHandle) { return 0; }
int cuLaunchKernel(CuHandle function, unsigned blocks, unsigned, unsigned, unsigned threads, unsigned, unsigned,
                   unsigned, CuHandle stream, void** arguments, void**) {
  if (stream != handle(confined ? 4 : 2)) return kNotFound;
  std::vector<int> block_order(blocks);
  std::vector<int> thread_order(threads);
  std::iota(block_order.begin(), block_order.end(), 0);
  std::iota(thread_order.begin(), thread_order.end(), 0);
  shuffle(block_order);
  for (const int index : block_order) {
    shuffle(thread_order);
    run(static_cast<std::size_t>(reinterpret_cast<char*>(function) - handles),
        Block(index, static_cast<int>(blocks), thread_order), arguments);
  }
  return 0;
}
int cuOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, CuHandle, int, std::size_t) { return *blocks = 3, 0; }
int cuEventCreate(CuHandle* event, unsigned) {
  *event = handle(3);
  return 0;
}
int cuEventRecord(CuHandle, CuHandle) { return 0; }
int cuStreamWaitEvent(CuHandle, CuHandle, unsigned) { return 0; }
int cuEventSynchronize(CuHandle) { return 0; }
int cuEventElapsedTime(float* ms, CuHandle, CuHandle) {
  *ms = 0.0F;
  return 0;
}
int cuDeviceGetDevResource(int, CuResource* resource, int type) {
  if (std::getenv("FAKE_CUDA_NO_SHARES") != nullptr) return kNotSupported;
  *resource = {};
  resource->type = type;
  resource->processors = kProcessors;
  return 0;
}
int cuDevSmResourceSplitByCount(CuResource* result, unsigned* groups, const CuResource* all, CuResource*,
                                unsigned flags, unsigned least) {
  const unsigned step = flags == 0 ? 2 : 1;
  *result = *all;
  result->processors = (least + step - 1) / step * step;
  *groups = result->processors <= all->processors ? 1 : 0;
  return 0;
}
int cuDevResourceGenerateDesc(CuHandle* description, CuResource*, unsigned) {
  *description = handle(5);
  return 0;
}
int cuGreenCtxCreate(CuHandle* context, CuHandle description, int, unsigned flags) {
  *context = handle(6);
  return description == handle(5) && flags == 1 ? 0 : kNotFound;
}
int cuGreenCtxStreamCreate(CuHandle* stream, CuHandle context, unsigned flags, int) {
  *stream = handle(4);
  confined = true;
  return context == handle(6) && flags == 1 ? 0 : kNotFound;
}
int cuGetErrorName(int error, const char** name) {
  *name = error == kOutOfMemory    ? "CUDA_ERROR_OUT_OF_MEMORY"
          : error == kInvalidPtx   ? "CUDA_ERROR_INVALID_PTX"
          : error == kNotSupported ? "CUDA_ERROR_NOT_SUPPORTED"
                                   : "?";
  return 0;
}

}  // extern "C"
