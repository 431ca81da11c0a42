// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/image_intake.hpp"

#include <cstring>
#include <utility>

namespace g3d::hal::kinect {
namespace {

std::size_t pixel_bytes(ImageKind kind) { return kind == ImageKind::depth ? 2 : 3; }

}  // namespace

const char* to_string(ImageFault fault) {
  switch (fault) {
    case ImageFault::none:
      return "none";
    case ImageFault::half:
      return "half";
    case ImageFault::wrong_size:
      return "wrong_size";
    case ImageFault::wrong_format:
      return "wrong_format";
    case ImageFault::count_:
      break;
  }
  return "unknown";
}

ImageFault fault_of(const SensorImage& image, int width_px, int height_px) {
  if (!image.is_known_format) return ImageFault::wrong_format;
  if (image.width_px != width_px || image.height_px != height_px) return ImageFault::wrong_size;
  const std::size_t row_bytes = static_cast<std::size_t>(width_px) * pixel_bytes(image.kind);
  if (image.stride_bytes < 0 || static_cast<std::size_t>(image.stride_bytes) < row_bytes) return ImageFault::wrong_size;
  const std::size_t needed =
      static_cast<std::size_t>(image.stride_bytes) * static_cast<std::size_t>(height_px - 1) + row_bytes;
  return image.bytes.data() == nullptr || image.bytes.size() < needed ? ImageFault::half : ImageFault::none;
}

ImageIntake::ImageIntake(int width_px, int height_px)
    : width_px_(width_px),
      height_px_(height_px),
      pixels_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)),
      // Zeroed, so that the pages are there before the first image comes.
      depth_(std::make_unique<std::uint16_t[]>(kSlots * pixels_)),
      rgb_(std::make_unique<std::uint8_t[]>(3 * kSlots * pixels_)) {
  for (Lane& lane : lanes_) {
    for (std::uint32_t i = 0; i < kSlots; ++i) (void)lane.free.try_push(i);
  }
}

void ImageIntake::take(const SensorImage& image) {
  Lane& to = lane(image.kind);
  const ImageFault fault = fault_of(image, width_px_, height_px_);
  to.faults[static_cast<std::size_t>(fault)].fetch_add(1, std::memory_order_relaxed);
  if (fault != ImageFault::none) {
    if (image.kind == ImageKind::depth)
      enqueue(to, {kNoSlot, fault, image.index, image.device_ticks, image.arrived_ns});
    return;
  }
  std::uint32_t slot = kNoSlot;
  if (to.spare != kNoSlot) {
    slot = std::exchange(to.spare, kNoSlot);
  } else if (!to.free.try_pop(slot)) {
    to.overruns.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  const std::size_t row_bytes = static_cast<std::size_t>(width_px_) * pixel_bytes(image.kind);
  std::uint8_t* out = image.kind == ImageKind::depth ? reinterpret_cast<std::uint8_t*>(depth_.get() + slot * pixels_)
                                                     : rgb_.get() + 3 * slot * pixels_;
  const std::uint8_t* in = image.bytes.data();
  for (int v = 0; v < height_px_; ++v, in += image.stride_bytes, out += row_bytes) std::memcpy(out, in, row_bytes);
  enqueue(to, {slot, fault, image.index, image.device_ticks, image.arrived_ns});
}

void ImageIntake::enqueue(Lane& to, const Taken& taken) {
  const auto oldest = to.ready.push_overwrite_oldest(taken);
  if (!oldest) return;
  to.overruns.fetch_add(1, std::memory_order_relaxed);
  if (oldest->slot != kNoSlot) to.spare = oldest->slot;
}

bool ImageIntake::try_take(ImageKind kind, Taken& taken) { return lane(kind).ready.try_pop(taken); }

void ImageIntake::release(ImageKind kind, const Taken& taken) {
  if (taken.slot != kNoSlot) (void)lane(kind).free.try_push(taken.slot);
}

void ImageIntake::drain() {
  for (const ImageKind kind : {ImageKind::depth, ImageKind::colour}) {
    Taken taken;
    while (try_take(kind, taken)) release(kind, taken);
  }
}

}  // namespace g3d::hal::kinect
