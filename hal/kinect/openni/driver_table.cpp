// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/driver_table.hpp"

#include <Driver/OniDriverAPI.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <mutex>
#include <string_view>
#include <thread>
#include <type_traits>

// What every driver has to have: result, name, parameters. See OniDriverAPI.h.
#define G3D_ENTRY_POINTS(X, D)                                                                                \
  X(D, void, Create, (OniDriverServices*))                                                                    \
  X(D, void, Destroy, ())                                                                                     \
  X(D, OniStatus, Initialize,                                                                                 \
    (oni::driver::DeviceConnectedCallback, oni::driver::DeviceDisconnectedCallback,                           \
     oni::driver::DeviceStateChangedCallback, void*))                                                         \
  X(D, OniStatus, TryDevice, (const char*))                                                                   \
  X(D, oni::driver::DeviceBase*, DeviceOpen, (const char*, const char*))                                      \
  X(D, void, DeviceClose, (oni::driver::DeviceBase*))                                                         \
  X(D, OniStatus, DeviceGetSensorInfoList, (oni::driver::DeviceBase*, OniSensorInfo**, int*))                 \
  X(D, oni::driver::StreamBase*, DeviceCreateStream, (oni::driver::DeviceBase*, OniSensorType))               \
  X(D, void, DeviceDestroyStream, (oni::driver::DeviceBase*, oni::driver::StreamBase*))                       \
  X(D, OniStatus, DeviceSetProperty, (oni::driver::DeviceBase*, int, const void*, int))                       \
  X(D, OniStatus, DeviceGetProperty, (oni::driver::DeviceBase*, int, void*, int*))                            \
  X(D, OniBool, DeviceIsPropertySupported, (oni::driver::DeviceBase*, int))                                   \
  X(D, void, DeviceSetPropertyChangedCallback,                                                                \
    (oni::driver::DeviceBase*, oni::driver::PropertyChangedCallback, void*))                                  \
  X(D, void, DeviceNotifyAllProperties, (oni::driver::DeviceBase*))                                           \
  X(D, OniStatus, DeviceInvoke, (oni::driver::DeviceBase*, int, void*, int))                                  \
  X(D, OniBool, DeviceIsCommandSupported, (oni::driver::DeviceBase*, int))                                    \
  X(D, OniBool, DeviceIsImageRegistrationModeSupported, (oni::driver::DeviceBase*, OniImageRegistrationMode)) \
  X(D, OniStatus, DeviceTryManualTrigger, (oni::driver::DeviceBase*))                                         \
  X(D, void, StreamSetServices, (oni::driver::StreamBase*, OniStreamServices*))                               \
  X(D, OniStatus, StreamSetProperty, (oni::driver::StreamBase*, int, const void*, int))                       \
  X(D, OniStatus, StreamGetProperty, (oni::driver::StreamBase*, int, void*, int*))                            \
  X(D, OniBool, StreamIsPropertySupported, (oni::driver::StreamBase*, int))                                   \
  X(D, void, StreamSetPropertyChangedCallback,                                                                \
    (oni::driver::StreamBase*, oni::driver::PropertyChangedCallback, void*))                                  \
  X(D, void, StreamNotifyAllProperties, (oni::driver::StreamBase*))                                           \
  X(D, OniStatus, StreamInvoke, (oni::driver::StreamBase*, int, void*, int))                                  \
  X(D, OniBool, StreamIsCommandSupported, (oni::driver::StreamBase*, int))                                    \
  X(D, OniStatus, StreamStart, (oni::driver::StreamBase*))                                                    \
  X(D, void, StreamStop, (oni::driver::StreamBase*))                                                          \
  X(D, int, StreamGetRequiredFrameSize, (oni::driver::StreamBase*))                                           \
  X(D, void, StreamSetNewFrameCallback, (oni::driver::StreamBase*, oni::driver::NewFrameCallback, void*))     \
  X(D, OniStatus, StreamConvertDepthToColorCoordinates,                                                       \
    (oni::driver::StreamBase*, oni::driver::StreamBase*, int, int, OniDepthPixel, int*, int*))                \
  X(D, void*, EnableFrameSync, (oni::driver::StreamBase**, int))                                              \
  X(D, void, DisableFrameSync, (void*))

#define G3D_DECLARE(D, R, name, parameters) extern "C" R D##_oniDriver##name parameters;
G3D_ENTRY_POINTS(G3D_DECLARE, oni_file)
G3D_ENTRY_POINTS(G3D_DECLARE, freenect)
G3D_ENTRY_POINTS(G3D_DECLARE, virtual_kinect)

namespace g3d::hal::kinect::openni {
namespace {

std::atomic<Driver> selected{Driver::virtual_kinect};
std::array<std::atomic<bool>, static_cast<std::size_t>(Driver::count_)> is_created{};

std::atomic<std::uint64_t> exceptions{0};
std::mutex exception_mutex;
std::string exception_text;

void note_exception() {
  std::string text = "an exception";
  try {
    throw;
  } catch (const std::exception& e) {
    text = e.what();
  } catch (...) {
  }
  exceptions.fetch_add(1);
  const std::lock_guard lock(exception_mutex);
  exception_text = std::move(text);
}

template <typename R>
R failed() {
  if constexpr (std::is_same_v<R, OniStatus>) {
    return ONI_STATUS_ERROR;
  } else if constexpr (!std::is_void_v<R>) {
    return R{};
  }
}

// Frames on their way from a driver to the core.
struct Tap {
  std::atomic<oni::driver::StreamBase*> stream{nullptr};
  oni::driver::NewFrameCallback to_core = nullptr;
  void* core_cookie = nullptr;
};
std::array<Tap, 16> taps;
std::mutex taps_mutex;
std::atomic<ImageSink*> image_tap{nullptr};
std::atomic<const Clock*> tap_clock{nullptr};
std::atomic<int> threads_in_tap{0};

SensorImage image_of(const OniFrame& frame, TimeNs arrived_ns) {
  SensorImage image;
  image.kind = frame.sensorType == ONI_SENSOR_DEPTH ? ImageKind::depth : ImageKind::colour;
  image.width_px = frame.width;
  image.height_px = frame.height;
  image.stride_bytes = frame.stride;
  image.is_known_format = frame.videoMode.pixelFormat ==
                          (image.kind == ImageKind::depth ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888);
  image.bytes = {static_cast<const std::uint8_t*>(frame.data), static_cast<std::size_t>(std::max(frame.dataSize, 0))};
  image.device_ticks = frame.timestamp;
  image.index = static_cast<std::uint32_t>(frame.frameIndex);
  image.arrived_ns = arrived_ns;
  return image;
}

void on_new_frame(oni::driver::StreamBase* stream, OniFrame* frame, void* cookie) {
  const bool is_wanted =
      frame != nullptr && (frame->sensorType == ONI_SENSOR_DEPTH || frame->sensorType == ONI_SENSOR_COLOR);
  threads_in_tap.fetch_add(1);
  if (ImageSink* const tap = image_tap.load(); tap != nullptr && is_wanted) {
    tap->take(image_of(*frame, tap_clock.load()->now()));
  }
  threads_in_tap.fetch_sub(1);
  const Tap& own = *static_cast<Tap*>(cookie);
  own.to_core(stream, frame, own.core_cookie);
}

/// A driver's function as the core may call it.
template <Driver kDriver, auto kFunction>
struct Guarded;
template <Driver kDriver, typename R, typename... A, R (*kFunction)(A...)>
struct Guarded<kDriver, kFunction> {
  static R call(A... arguments) {
    try {
      return kFunction(arguments...);
    } catch (...) {
      note_exception();
      return failed<R>();
    }
  }
  /// For those that need what Create made.
  static R call_created(A... arguments) {
    return is_created[static_cast<std::size_t>(kDriver)].load() ? call(arguments...) : failed<R>();
  }
};

template <Driver kDriver, void (*kCreate)(OniDriverServices*)>
void create(OniDriverServices* services) {
  const std::uint64_t before = exceptions.load();
  Guarded<kDriver, kCreate>::call(services);
  is_created[static_cast<std::size_t>(kDriver)].store(exceptions.load() == before);
}

template <Driver kDriver, void (*kDestroy)()>
void destroy() {
  Guarded<kDriver, kDestroy>::call_created();
  is_created[static_cast<std::size_t>(kDriver)].store(false);
}

template <void (*kSet)(oni::driver::StreamBase*, oni::driver::NewFrameCallback, void*)>
void set_new_frame_callback(oni::driver::StreamBase* stream, oni::driver::NewFrameCallback to_core, void* cookie) {
  const std::lock_guard lock(taps_mutex);
  const auto is_its = [stream](const Tap& tap) { return tap.stream.load() == stream; };
  auto own = std::find_if(taps.begin(), taps.end(), is_its);
  if (own == taps.end()) {
    own = std::find_if(taps.begin(), taps.end(), [](const Tap& tap) { return tap.stream.load() == nullptr; });
  }
  if (own == taps.end()) return kSet(stream, to_core, cookie);
  own->to_core = to_core;
  own->core_cookie = cookie;
  own->stream.store(stream);
  kSet(stream, on_new_frame, &*own);
}

template <Driver kDriver, void (*kDestroyStream)(oni::driver::DeviceBase*, oni::driver::StreamBase*)>
void destroy_stream(oni::driver::DeviceBase* device, oni::driver::StreamBase* stream) {
  Guarded<kDriver, kDestroyStream>::call(device, stream);
  const std::lock_guard lock(taps_mutex);
  for (Tap& tap : taps) {
    if (tap.stream.load() == stream) tap.stream.store(nullptr);
  }
}

struct EntryPoint {
  std::string_view name;
  void* function;
};

template <typename F>
void* address(F* function) {
  return reinterpret_cast<void*>(function);
}

// Later entries of a name do not count: those that are special come first.
#define G3D_SPECIAL(D)                                                                                          \
  {"oniDriverCreate", address(&create<Driver::D, D##_oniDriverCreate>)},                                        \
      {"oniDriverDestroy", address(&destroy<Driver::D, D##_oniDriverDestroy>)},                                 \
      {"oniDriverInitialize", address(&Guarded<Driver::D, D##_oniDriverInitialize>::call_created)},             \
      {"oniDriverTryDevice", address(&Guarded<Driver::D, D##_oniDriverTryDevice>::call_created)},               \
      {"oniDriverDeviceOpen", address(&Guarded<Driver::D, D##_oniDriverDeviceOpen>::call_created)},             \
      {"oniDriverEnableFrameSync", address(&Guarded<Driver::D, D##_oniDriverEnableFrameSync>::call_created)},   \
      {"oniDriverDisableFrameSync", address(&Guarded<Driver::D, D##_oniDriverDisableFrameSync>::call_created)}, \
      {"oniDriverStreamSetNewFrameCallback",                                                                    \
       address(&set_new_frame_callback<D##_oniDriverStreamSetNewFrameCallback>)},                               \
      {"oniDriverDeviceDestroyStream", address(&destroy_stream<Driver::D, D##_oniDriverDeviceDestroyStream>)},
#define G3D_GUARDED(D, R, name, parameters) \
  {"oniDriver" #name, address(&Guarded<Driver::D, D##_oniDriver##name>::call)},

struct TableEntry {
  const char* name;
  std::array<EntryPoint, 42> functions;
};
const std::array<TableEntry, static_cast<std::size_t>(Driver::count_)> table{{
    {"oni_file", {{G3D_SPECIAL(oni_file) G3D_ENTRY_POINTS(G3D_GUARDED, oni_file)}}},
    {"freenect", {{G3D_SPECIAL(freenect) G3D_ENTRY_POINTS(G3D_GUARDED, freenect)}}},
    {"virtual_kinect", {{G3D_SPECIAL(virtual_kinect) G3D_ENTRY_POINTS(G3D_GUARDED, virtual_kinect)}}},
}};
#undef G3D_GUARDED
#undef G3D_SPECIAL
#undef G3D_DECLARE
#undef G3D_ENTRY_POINTS

}  // namespace

void select_driver(Driver driver) { selected.store(driver); }

std::uint64_t driver_exceptions() { return exceptions.load(); }

std::string last_driver_exception() {
  const std::lock_guard lock(exception_mutex);
  return exception_text;
}

void set_image_tap(ImageSink* tap, const Clock* clock) {
  if (tap != nullptr) tap_clock.store(clock);
  image_tap.store(tap);
  while (threads_in_tap.load() != 0) std::this_thread::yield();
}

}  // namespace g3d::hal::kinect::openni

// What the core calls in place of the C library's loader. Its status is 0 for success, its paths are 256 bytes long.
namespace {

using g3d::hal::kinect::openni::Driver;

constexpr std::size_t kPathBytes = 256;
constexpr std::uint32_t kXnOk = 0;
constexpr std::uint32_t kXnError = 0x10001;

void copy_path(char* to, const char* from) {
  std::memset(to, 0, kPathBytes);
  std::memcpy(to, from, std::min(std::strlen(from), kPathBytes - 1));
}

}  // namespace

extern "C" {

std::uint32_t g3d_xnOSLoadLibrary(const char* file, void** library);
std::uint32_t g3d_xnOSFreeLibrary(void* library);
std::uint32_t g3d_xnOSGetProcAddress(void* library, const char* name, void** function);
std::uint32_t g3d_xnOSCountFiles(const char* pattern, std::int32_t* count);
std::uint32_t g3d_xnOSGetFileList(const char* pattern, const char* prefix, char (*files)[kPathBytes], std::int32_t most,
                                  std::int32_t* count);
std::uint32_t g3d_xnOSGetModulePathForProcAddress(void* address, char* path);

std::uint32_t g3d_xnOSLoadLibrary(const char* file, void** library) {
  for (const auto& entry : g3d::hal::kinect::openni::table) {
    if (std::strcmp(file, entry.name) != 0) continue;
    *library = const_cast<void*>(static_cast<const void*>(&entry));
    return kXnOk;
  }
  return kXnError;
}

std::uint32_t g3d_xnOSFreeLibrary(void*) { return kXnOk; }

std::uint32_t g3d_xnOSGetProcAddress(void* library, const char* name, void** function) {
  for (const auto& entry : static_cast<const g3d::hal::kinect::openni::TableEntry*>(library)->functions) {
    if (entry.name != name) continue;
    *function = entry.function;
    return kXnOk;
  }
  return kXnError;
}

std::uint32_t g3d_xnOSCountFiles(const char*, std::int32_t* count) {
  *count = 1;
  return kXnOk;
}

std::uint32_t g3d_xnOSGetFileList(const char*, const char*, char (*files)[kPathBytes], std::int32_t most,
                                  std::int32_t* count) {
  if (most < 1) return kXnError;
  const Driver driver = g3d::hal::kinect::openni::selected.load();
  copy_path(files[0], g3d::hal::kinect::openni::table[static_cast<std::size_t>(driver)].name);
  *count = 1;
  return kXnOk;
}

// A folder where nobody keeps an OpenNI.ini.
std::uint32_t g3d_xnOSGetModulePathForProcAddress(void*, char* path) {
  copy_path(path, "/nonexistent/g3dmap");
  return kXnOk;
}

}  // extern "C"
