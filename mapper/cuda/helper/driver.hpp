// SPDX-License-Identifier: Apache-2.0
// The part of the CUDA driver API that the helper uses, found at run time: neither toolkit nor headers are needed. The
// names and numbers are the driver's public ABI, in versions that CUDA 10.2 and all later drivers export.
#pragma once

#include <cstddef>
#include <cstdint>

namespace g3d::mapper::cuda {

using CuDevicePointer = unsigned long long;
struct CuOpaque;
using CuHandle = CuOpaque*;
struct CuResource;  ///< see few_processors.hpp

struct Driver {
  int (*init)(unsigned);
  int (*device_get)(int*, int);
  int (*device_get_name)(char*, int, int);
  int (*device_get_attribute)(int*, int, int);
  int (*primary_context_retain)(CuHandle*, int);
  int (*primary_context_set_flags)(int, unsigned);
  int (*context_set_current)(CuHandle);
  int (*module_load_data_ex)(CuHandle*, const void*, unsigned, int*, void**);
  int (*module_get_function)(CuHandle*, CuHandle, const char*);
  int (*module_get_global)(CuDevicePointer*, std::size_t*, CuHandle, const char*);
  int (*mem_alloc)(CuDevicePointer*, std::size_t);
  int (*memset_d8)(CuDevicePointer, unsigned char, std::size_t);
  int (*copy_to_card)(CuDevicePointer, const void*, std::size_t);
  int (*copy_to_card_async)(CuDevicePointer, const void*, std::size_t, CuHandle);
  int (*copy_to_host)(void*, CuDevicePointer, std::size_t);
  int (*copy_to_host_async)(void*, CuDevicePointer, std::size_t, CuHandle);
  int (*host_register)(void*, std::size_t, unsigned);
  int (*host_get_device_pointer)(CuDevicePointer*, void*, unsigned);
  int (*stream_create)(CuHandle*, unsigned);
  int (*stream_synchronize)(CuHandle);
  int (*launch_kernel)(CuHandle, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, CuHandle, void**,
                       void**);
  int (*max_active_blocks)(int*, CuHandle, int, std::size_t);
  int (*event_create)(CuHandle*, unsigned);
  int (*event_record)(CuHandle, CuHandle);
  int (*stream_wait_event)(CuHandle, CuHandle, unsigned);
  int (*event_synchronize)(CuHandle);
  int (*event_elapsed_time)(float*, CuHandle, CuHandle);
  int (*get_error_name)(int, const char**);
  // Not in every driver: launches go out one by one without them
  int (*stream_begin_capture)(CuHandle, int);
  int (*stream_end_capture)(CuHandle, CuHandle*);
  int (*graph_instantiate)(CuHandle*, CuHandle, unsigned long long);
  int (*graph_launch)(CuHandle, CuHandle);
  // From CUDA 12.5 on: for measurements alone
  int (*device_get_resource)(int, CuResource*, int);
  int (*split_resource)(CuResource*, unsigned*, const CuResource*, CuResource*, unsigned, unsigned);
  int (*describe_resource)(CuHandle*, CuResource*, unsigned);
  int (*green_context_create)(CuHandle*, CuHandle, int, unsigned);
  int (*green_stream_create)(CuHandle*, CuHandle, unsigned, int);
};

/// Name of the first function that is missing, or of the library if it cannot be loaded; nullptr if all is there.
const char* load_driver(Driver& driver);

}  // namespace g3d::mapper::cuda
