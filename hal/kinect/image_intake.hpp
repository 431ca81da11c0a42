// SPDX-License-Identifier: Apache-2.0
// From a driver's threads to the camera's: images are checked, copied into slots that were allocated before, and
// queued. A camera thread that is behind loses the oldest waiting image, never the newest. Images that cannot be used
// are counted by reason, and a bad depth image is passed on as such, so that every delivered frame is accounted for.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "hal/kinect/sensor_link.hpp"
#include "hal/ring.hpp"

namespace g3d::hal::kinect {

enum class ImageFault : std::uint8_t {
  none,
  half,        ///< fewer bytes than its size announces
  wrong_size,  ///< of another size than the camera model
  wrong_format,
  count_,
};
inline constexpr std::size_t kImageFaults = static_cast<std::size_t>(ImageFault::count_);
[[nodiscard]] const char* to_string(ImageFault fault);

/// What is wrong with an image where `width` x `height` are wanted.
[[nodiscard]] ImageFault fault_of(const SensorImage& image, int width_px, int height_px);

class ImageIntake final : public ImageSink {
 public:
  /// Of each kind: one is written, two are in the hands of the camera thread, six wait: a fifth of a second.
  static constexpr std::size_t kSlots = 9;

  ImageIntake(int width_px, int height_px);

  /// Driver's threads, one per kind. Allocates nothing.
  void take(const SensorImage& image) override;

  /// A queued image in the hands of the camera thread; give it back by release().
  struct Taken {
    std::uint32_t slot = 0;
    ImageFault fault = ImageFault::none;  ///< if there is one, the slot's bytes are those of an older image
    std::uint32_t index = 0;
    std::uint64_t device_ticks = 0;
    TimeNs arrived_ns = 0;
  };
  // The camera thread.
  [[nodiscard]] bool try_take(ImageKind kind, Taken& taken);
  void release(ImageKind kind, const Taken& taken);
  [[nodiscard]] const std::uint16_t* depth(const Taken& taken) const { return depth_.get() + taken.slot * pixels_; }
  [[nodiscard]] const std::uint8_t* rgb(const Taken& taken) const { return rgb_.get() + 3 * taken.slot * pixels_; }
  /// Throws away what is queued. While no driver is open.
  void drain();

  // Any thread.
  [[nodiscard]] std::uint64_t faults(ImageKind kind, ImageFault fault) const {
    return lane(kind).faults[static_cast<std::size_t>(fault)].load(std::memory_order_relaxed);
  }
  /// Images that were lost because the camera thread was behind.
  [[nodiscard]] std::uint64_t overruns(ImageKind kind) const {
    return lane(kind).overruns.load(std::memory_order_relaxed);
  }

 private:
  // An image that cannot be used takes no slot with it.
  static constexpr std::uint32_t kNoSlot = ~std::uint32_t{0};
  struct Lane {
    Ring<std::uint32_t> free{kSlots};
    Ring<Taken> ready{kSlots - 3};
    std::array<std::atomic<std::uint64_t>, kImageFaults> faults{};
    std::atomic<std::uint64_t> overruns{0};
    std::uint32_t spare = kNoSlot;  ///< the driver's: taken out of `ready`, to be filled next
  };
  [[nodiscard]] Lane& lane(ImageKind kind) { return lanes_[static_cast<std::size_t>(kind)]; }
  [[nodiscard]] const Lane& lane(ImageKind kind) const { return lanes_[static_cast<std::size_t>(kind)]; }
  static void enqueue(Lane& to, const Taken& taken);

  int width_px_;
  int height_px_;
  std::size_t pixels_;
  std::unique_ptr<std::uint16_t[]> depth_;
  std::unique_ptr<std::uint8_t[]> rgb_;
  std::array<Lane, 2> lanes_;
};

}  // namespace g3d::hal::kinect
