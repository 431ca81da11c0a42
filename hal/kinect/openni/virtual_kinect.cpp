// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/virtual_kinect.hpp"

#include <rename_virtual_kinect.h>

#include <Driver/OniDriverAPI.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <functional>
#include <mutex>
#include <thread>

#include "hal/frame_pool.hpp"
#include "hal/kinect/sensor_link.hpp"

namespace g3d::hal::kinect::openni {

struct VirtualKinect::State {
  State(Show show_, Clock& clock_, const VirtualKinectOptions& options_)
      : show(std::move(show_)), clock(clock_), options(options_) {}

  const Show show;
  Clock& clock;
  const VirtualKinectOptions options;
  std::mutex show_mutex;  // whoever has it may show, unless the source is gone
  bool is_gone = false;
  std::atomic<bool> is_plugged_in{true};
  std::atomic<bool> is_silent{false};
  std::atomic<int> halves{0};
  std::atomic<std::uint64_t> sent{0};
};

namespace {

constexpr float kHorizontalFov_rad = 1.0946F;  // of 525 px
constexpr float kVerticalFov_rad = 0.8580F;
constexpr int kFarthest_mm = 10'000;

// What is plugged in, or would be.
std::mutex socket_mutex;
std::shared_ptr<VirtualKinect::State> socket_state;

OniVideoMode mode_of(OniSensorType sensor) {
  return {sensor == ONI_SENSOR_DEPTH ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888, kWidth_px, kHeight_px,
          30};
}

class VirtualStream final : public oni::driver::StreamBase {
 public:
  VirtualStream(OniSensorType sensor, std::shared_ptr<VirtualKinect::State> state)
      : sensor_(sensor), state_(std::move(state)), mode_(mode_of(sensor)) {}

  OniStatus start() override {
    const std::lock_guard lock(mutex_);
    is_running_ = true;
    return ONI_STATUS_OK;
  }
  void stop() override {
    const std::lock_guard lock(mutex_);
    is_running_ = false;
  }

  /// The device's thread. `height_px`: fewer rows than there should be are half an image.
  void send(const Frame& frame, std::uint64_t tick_us, std::uint64_t number, int height_px) {
    const std::lock_guard lock(mutex_);
    if (!is_running_) return;
    OniFrame* const out = getServices().acquireFrame();
    if (out == nullptr) return;
    const bool is_depth = sensor_ == ONI_SENSOR_DEPTH;
    const int pixel_bytes = is_depth ? 2 : 3;
    const int stride_bytes = kWidth_px * pixel_bytes;
    out->sensorType = sensor_;
    out->timestamp = tick_us;
    out->frameIndex = static_cast<int>(number);
    out->videoMode = mode_;
    const bool is_cropped = cropping_.enabled != 0;
    out->croppingEnabled = cropping_.enabled;
    out->cropOriginX = is_cropped ? cropping_.originX : 0;
    out->cropOriginY = is_cropped ? cropping_.originY : 0;
    out->width = is_cropped ? cropping_.width : kWidth_px;
    out->height = is_cropped ? cropping_.height : kHeight_px;
    out->stride = out->width * pixel_bytes;
    const int rows = std::min(height_px, out->height);
    out->dataSize = std::min(out->dataSize, out->stride * rows);
    const auto* const in = is_depth ? reinterpret_cast<const std::uint8_t*>(frame.depth.get()) : frame.rgb.get();
    auto* const to = static_cast<std::uint8_t*>(out->data);
    for (int v = 0; v < rows && (v + 1) * out->stride <= out->dataSize; ++v) {
      std::memcpy(to + v * out->stride, in + (v + out->cropOriginY) * stride_bytes + out->cropOriginX * pixel_bytes,
                  static_cast<std::size_t>(out->stride));
    }
    raiseNewFrame(out);
    getServices().releaseFrame(out);
  }

  OniBool isPropertySupported(int id) override {
    switch (id) {
      case ONI_STREAM_PROPERTY_VIDEO_MODE:
      case ONI_STREAM_PROPERTY_CROPPING:
      case ONI_STREAM_PROPERTY_STRIDE:
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return TRUE;
      case ONI_STREAM_PROPERTY_MAX_VALUE:
        return sensor_ == ONI_SENSOR_DEPTH ? TRUE : FALSE;
      default:
        return FALSE;
    }
  }

  OniStatus getProperty(int id, void* data, int* size) override {
    switch (id) {
      case ONI_STREAM_PROPERTY_VIDEO_MODE:
        return give(mode_, data, size);
      case ONI_STREAM_PROPERTY_CROPPING:
        return give(cropping_, data, size);
      case ONI_STREAM_PROPERTY_STRIDE:
        return give(kWidth_px * (sensor_ == ONI_SENSOR_DEPTH ? 2 : 3), data, size);
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        return give(kHorizontalFov_rad, data, size);
      case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return give(kVerticalFov_rad, data, size);
      case ONI_STREAM_PROPERTY_MAX_VALUE:
        return sensor_ == ONI_SENSOR_DEPTH ? give(kFarthest_mm, data, size) : ONI_STATUS_NOT_SUPPORTED;
      default:
        return ONI_STATUS_NOT_SUPPORTED;
    }
  }

  OniStatus setProperty(int id, const void* data, int size) override {
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) {
      OniVideoMode wanted;
      if (!take(wanted, data, size)) return ONI_STATUS_BAD_PARAMETER;
      return std::memcmp(&wanted, &mode_, sizeof mode_) == 0 ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
    }
    if (id == ONI_STREAM_PROPERTY_CROPPING) {
      OniCropping wanted;
      if (!take(wanted, data, size)) return ONI_STATUS_BAD_PARAMETER;
      const bool fits = wanted.originX >= 0 && wanted.originY >= 0 && wanted.width > 0 && wanted.height > 0 &&
                        wanted.width <= kWidth_px - wanted.originX && wanted.height <= kHeight_px - wanted.originY;
      if (wanted.enabled != 0 && !fits) return ONI_STATUS_BAD_PARAMETER;
      const std::lock_guard lock(mutex_);
      cropping_ = wanted;
      return ONI_STATUS_OK;
    }
    return ONI_STATUS_NOT_SUPPORTED;
  }

  void notifyAllProperties() override {
    for (const int id : {ONI_STREAM_PROPERTY_VIDEO_MODE, ONI_STREAM_PROPERTY_CROPPING, ONI_STREAM_PROPERTY_STRIDE,
                         ONI_STREAM_PROPERTY_HORIZONTAL_FOV, ONI_STREAM_PROPERTY_VERTICAL_FOV}) {
      std::array<std::uint8_t, sizeof(OniCropping)> bytes{};
      for (int size : {4, static_cast<int>(sizeof(OniVideoMode)), static_cast<int>(sizeof(OniCropping))}) {
        if (getProperty(id, bytes.data(), &size) == ONI_STATUS_OK) raisePropertyChanged(id, bytes.data(), size);
      }
    }
  }

 private:
  template <typename T>
  static OniStatus give(const T& value, void* data, const int* size) {
    if (*size != static_cast<int>(sizeof(T))) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(data, &value, sizeof(T));
    return ONI_STATUS_OK;
  }
  template <typename T>
  static bool take(T& value, const void* data, int size) {
    if (size != static_cast<int>(sizeof(T))) return false;
    std::memcpy(&value, data, sizeof(T));
    return true;
  }

  const OniSensorType sensor_;
  const std::shared_ptr<VirtualKinect::State> state_;
  const OniVideoMode mode_;
  std::mutex mutex_;  // guards what follows, and that nobody sends once it is stopped
  OniCropping cropping_{};
  bool is_running_ = false;
};

class VirtualDevice final : public oni::driver::DeviceBase {
 public:
  /// `on_pulled_out` is called once, by the device's thread: the driver's own calls may wait for the core's lock.
  VirtualDevice(std::shared_ptr<VirtualKinect::State> state, std::function<void()> on_pulled_out)
      : state_(std::move(state)),
        on_pulled_out_(std::move(on_pulled_out)),
        depth_(ONI_SENSOR_DEPTH, state_),
        colour_(ONI_SENSOR_COLOR, state_) {
    for (std::size_t i = 0; i < 2; ++i) {
      modes_[i] = mode_of(i == 0 ? ONI_SENSOR_DEPTH : ONI_SENSOR_COLOR);
      sensors_[i] = {i == 0 ? ONI_SENSOR_DEPTH : ONI_SENSOR_COLOR, 1, &modes_[i]};
    }
    thread_ = std::thread([this] { run(); });
  }
  ~VirtualDevice() override {
    ending_.store(true);
    thread_.join();
  }

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = sensors_.data();
    *count = static_cast<int>(sensors_.size());
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType sensor) override {
    if (sensor == ONI_SENSOR_DEPTH) return &depth_;
    return sensor == ONI_SENSOR_COLOR ? &colour_ : nullptr;
  }
  void destroyStream(oni::driver::StreamBase* stream) override { static_cast<VirtualStream*>(stream)->stop(); }

  OniBool isPropertySupported(int id) override { return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION ? TRUE : FALSE; }
  OniStatus getProperty(int id, void* data, int* size) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || *size != sizeof registration_) return ONI_STATUS_NOT_SUPPORTED;
    std::memcpy(data, &registration_, sizeof registration_);
    return ONI_STATUS_OK;
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    OniImageRegistrationMode wanted;
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || size != sizeof wanted) return ONI_STATUS_NOT_SUPPORTED;
    std::memcpy(&wanted, data, sizeof wanted);
    if (isImageRegistrationModeSupported(wanted) == FALSE) return ONI_STATUS_NOT_SUPPORTED;
    registration_ = wanted;
    return ONI_STATUS_OK;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_OFF || state_->options.is_registered ? TRUE : FALSE;
  }

 private:
  void run() {
    Frame frame = make_frame(CameraModel{});
    const auto period_ns = static_cast<TimeNs>(1e9 / state_->options.rate_hz);
    const TimeNs begin_ns = state_->clock.now();
    for (std::uint64_t number = 1; !ending_.load(); ++number) {
      state_->clock.sleep_until(begin_ns + static_cast<TimeNs>(number) * period_ns);
      if (ending_.load()) return;
      if (!state_->is_plugged_in.load()) return on_pulled_out_();
      if (state_->is_silent.load()) continue;
      {
        const std::lock_guard lock(state_->show_mutex);
        if (state_->is_gone || !state_->show(number, frame)) continue;
      }
      const std::uint64_t tick_us =
          state_->options.first_tick_us + number * static_cast<std::uint64_t>(period_ns) / 1000;
      colour_.send(frame, tick_us, number, kHeight_px);
      int halves = state_->halves.load();
      while (halves > 0 && !state_->halves.compare_exchange_weak(halves, halves - 1)) {
      }
      depth_.send(frame, tick_us, number, halves > 0 ? kHeight_px / 2 : kHeight_px);
      state_->sent.fetch_add(1);
    }
  }

  const std::shared_ptr<VirtualKinect::State> state_;
  const std::function<void()> on_pulled_out_;
  std::array<OniVideoMode, 2> modes_{};
  std::array<OniSensorInfo, 2> sensors_{};
  OniImageRegistrationMode registration_ = ONI_IMAGE_REGISTRATION_OFF;
  VirtualStream depth_;
  VirtualStream colour_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

class VirtualDriver final : public oni::driver::DriverBase {
 public:
  explicit VirtualDriver(OniDriverServices* services) : DriverBase(services) {
    std::strcpy(info_.uri, "virtual://kinect");
    std::strcpy(info_.vendor, "G3DMap");
    std::strcpy(info_.name, "virtual Kinect");
  }

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    (void)DriverBase::initialize(connected, disconnected, changed, cookie);
    const std::lock_guard lock(socket_mutex);
    if (socket_state != nullptr && socket_state->is_plugged_in.load()) deviceConnected(&info_);
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char* uri, const char* /*mode*/) override {
    const std::lock_guard lock(socket_mutex);
    if (std::strcmp(uri, info_.uri) != 0 || socket_state == nullptr || !socket_state->is_plugged_in.load())
      return nullptr;
    return new VirtualDevice(socket_state, [this] { deviceDisconnected(&info_); });
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {}

 private:
  OniDeviceInfo info_{};
};

}  // namespace

VirtualKinect::VirtualKinect(Show show, Clock& clock, const VirtualKinectOptions& options)
    : state_(std::make_shared<State>(std::move(show), clock, options)) {
  const std::lock_guard lock(socket_mutex);
  socket_state = state_;
}

VirtualKinect::~VirtualKinect() {
  pull_out();
  const std::lock_guard lock(socket_mutex);
  if (socket_state == state_) socket_state = nullptr;
  const std::lock_guard show_lock(state_->show_mutex);
  state_->is_gone = true;
}

void VirtualKinect::plug_in() { state_->is_plugged_in.store(true); }
void VirtualKinect::pull_out() { state_->is_plugged_in.store(false); }
void VirtualKinect::set_silent(bool is_silent) { state_->is_silent.store(is_silent); }
void VirtualKinect::send_half(int count) { state_->halves.store(count); }
std::uint64_t VirtualKinect::sent() const { return state_->sent.load(); }

}  // namespace g3d::hal::kinect::openni

#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(p) delete (p)
ONI_EXPORT_DRIVER(g3d::hal::kinect::openni::VirtualDriver)
