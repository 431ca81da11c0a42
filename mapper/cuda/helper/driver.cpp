// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/helper/driver.hpp"

#include <dlfcn.h>

namespace g3d::mapper::cuda {
namespace {

struct Entry {
  const char* name;
  void** function;
  bool needed;
};

template <typename Function>
Entry entry(const char* name, Function& function, bool needed = true) {
  return {name, reinterpret_cast<void**>(&function), needed};
}

}  // namespace

const char* load_driver(Driver& d) {
  constexpr const char* kLibrary = "libcuda.so.1";
  void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return kLibrary;
  const Entry entries[] = {
      entry("cuInit", d.init),
      entry("cuDeviceGet", d.device_get),
      entry("cuDeviceGetName", d.device_get_name),
      entry("cuDeviceGetAttribute", d.device_get_attribute),
      entry("cuDevicePrimaryCtxRetain", d.primary_context_retain),
      entry("cuDevicePrimaryCtxSetFlags", d.primary_context_set_flags),
      entry("cuCtxSetCurrent", d.context_set_current),
      entry("cuModuleLoadDataEx", d.module_load_data_ex),
      entry("cuModuleGetFunction", d.module_get_function),
      entry("cuModuleGetGlobal_v2", d.module_get_global),
      entry("cuMemAlloc_v2", d.mem_alloc),
      entry("cuMemsetD8_v2", d.memset_d8),
      entry("cuMemcpyHtoD_v2", d.copy_to_card),
      entry("cuMemcpyHtoDAsync_v2", d.copy_to_card_async),
      entry("cuMemcpyDtoH_v2", d.copy_to_host),
      entry("cuMemcpyDtoHAsync_v2", d.copy_to_host_async),
      entry("cuMemHostRegister_v2", d.host_register),
      entry("cuMemHostGetDevicePointer_v2", d.host_get_device_pointer),
      entry("cuStreamCreate", d.stream_create),
      entry("cuStreamSynchronize", d.stream_synchronize),
      entry("cuLaunchKernel", d.launch_kernel),
      entry("cuOccupancyMaxActiveBlocksPerMultiprocessor", d.max_active_blocks),
      entry("cuEventCreate", d.event_create),
      entry("cuEventRecord", d.event_record),
      entry("cuStreamWaitEvent", d.stream_wait_event),
      entry("cuEventSynchronize", d.event_synchronize),
      entry("cuEventElapsedTime", d.event_elapsed_time),
      entry("cuGetErrorName", d.get_error_name),
      entry("cuStreamBeginCapture_v2", d.stream_begin_capture, false),
      entry("cuStreamEndCapture", d.stream_end_capture, false),
      entry("cuGraphInstantiateWithFlags", d.graph_instantiate, false),
      entry("cuGraphLaunch", d.graph_launch, false),
      entry("cuDeviceGetDevResource", d.device_get_resource, false),
      entry("cuDevSmResourceSplitByCount", d.split_resource, false),
      entry("cuDevResourceGenerateDesc", d.describe_resource, false),
      entry("cuGreenCtxCreate", d.green_context_create, false),
      entry("cuGreenCtxStreamCreate", d.green_stream_create, false),
  };
  for (const Entry& e : entries) {
    *e.function = dlsym(library, e.name);
    if (e.needed && *e.function == nullptr) return e.name;
  }
  return nullptr;
}

}  // namespace g3d::mapper::cuda
