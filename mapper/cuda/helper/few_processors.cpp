// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/helper/few_processors.hpp"

#include "mapper/cuda/helper/text.hpp"

namespace g3d::mapper::cuda {
namespace {

constexpr int kProcessorResource = 1;   // CU_DEV_RESOURCE_TYPE_SM
constexpr unsigned kDefaultStream = 1;  // CU_GREEN_CTX_DEFAULT_STREAM: required
constexpr unsigned kNonBlocking = 1;    // CU_STREAM_NON_BLOCKING: required
// 0: multiprocessors that share clusters, eight or a multiple of it on Hopper; 1 (CU_DEV_SM_RESOURCE_SPLIT_
// IGNORE_SM_COSCHEDULING): any two. The kernels use no clusters.
constexpr unsigned kSplits[] = {0, 1};

}  // namespace

bool confine(const Driver& driver, int device, HelperControl& control, CuHandle& stream, unsigned& processors) {
  const auto failed = [&](int result, const char* what) {
    const char* name = nullptr;
    if (result != 0) driver.get_error_name(result, &name);
    if (result != 0) put_text(control.note, sizeof control.note, what, ": ", name);
    return result != 0;
  };
  if (driver.device_get_resource == nullptr || driver.split_resource == nullptr ||
      driver.describe_resource == nullptr || driver.green_context_create == nullptr ||
      driver.green_stream_create == nullptr) {
    put_text(control.note, sizeof control.note, "this driver is too old to share out the card", "", "");
    return false;
  }
  CuResource all{};
  if (failed(driver.device_get_resource(device, &all, kProcessorResource), "cuDeviceGetDevResource")) return false;
  put_text(control.note, sizeof control.note, "the card has no such share", "", "");
  CuResource best{};
  for (const unsigned split : kSplits) {
    CuResource part{};
    unsigned groups = 1;
    const int refused = driver.split_resource(&part, &groups, &all, nullptr, split, control.wanted_processors);
    if (failed(refused, "cuDevSmResourceSplitByCount") || groups == 0 || part.processors == 0) continue;
    if (best.processors == 0 || part.processors < best.processors) best = part;
    if (best.processors <= control.wanted_processors) break;
  }
  if (best.processors == 0) return false;
  CuHandle description = nullptr;
  CuHandle context = nullptr;
  if (failed(driver.describe_resource(&description, &best, 1), "cuDevResourceGenerateDesc") ||
      failed(driver.green_context_create(&context, description, device, kDefaultStream), "cuGreenCtxCreate") ||
      failed(driver.green_stream_create(&stream, context, kNonBlocking, 0), "cuGreenCtxStreamCreate")) {
    return false;
  }
  control.note[0] = 0;
  processors = best.processors;
  return true;
}

}  // namespace g3d::mapper::cuda
