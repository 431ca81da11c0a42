// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/kinect_camera.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace g3d::hal::kinect {
namespace {

constexpr TimeNs kClosedPoll_ns = 20'000'000;  // how soon stop() is heeded while no sensor is there

SensorStampOptions stamp_options(const SensorInfo& sensor, const Calibration& calibration) {
  return {sensor.tick_ns, sensor.tick_bits, static_cast<TimeNs>(calibration.latency_ms * 1e6)};
}

}  // namespace

KinectCamera::KinectCamera(std::unique_ptr<SensorLink> link, Clock& clock, const KinectOptions& options)
    : link_(std::move(link)),
      clock_(clock),
      options_(options),
      model_(colour_model(options.calibration)),
      intake_(kWidth_px, kHeight_px),
      colours_(intake_),
      depth_table_(options.calibration),
      registration_(options.calibration),
      corrected_mm_(static_cast<std::size_t>(kWidth_px) * kHeight_px),
      retry_ns_(options.first_retry_ns) {}

KinectCamera::~KinectCamera() { link_->close(); }

Result<void> KinectCamera::open() {
  auto opened = link_->open(intake_);
  if (!opened) {
    ++counts_.open_failures;
    publish();
    return opened.error();
  }
  sensor_ = std::move(opened).value();
  stamps_.emplace(stamp_options(sensor_, options_.calibration));
  colours_.begin(sensor_.tick_ns, sensor_.tick_bits);
  is_open_ = true;
  opened_ns_ = clock_.now();
  last_image_ns_ = 0;
  last_index_.reset();
  ++counts_.opened;
  publish();
  return {};
}

void KinectCamera::lose(std::string reason) {
  link_->close();
  colours_.begin(sensor_.tick_ns, sensor_.tick_bits);
  intake_.drain();
  is_open_ = false;
  last_error_ = std::move(reason);
  // At once for the first time: a cable that was touched is back already.
  next_try_ns_ = clock_.now();
  publish();
}

void KinectCamera::try_to_open() {
  const TimeNs now_ns = clock_.now();
  if (now_ns < next_try_ns_) {
    clock_.sleep_until(std::min(next_try_ns_, now_ns + kClosedPoll_ns));
    return;
  }
  if (const auto opened = open(); !opened) {
    last_error_ = opened.error().text;
    next_try_ns_ = clock_.now() + retry_ns_;
    retry_ns_ = std::min(2 * retry_ns_, options_.last_retry_ns);
  }
}

CameraRead KinectCamera::read(Frame& out) {
  while (!stopped_.load(std::memory_order_acquire)) {
    if (!is_open_) {
      try_to_open();
      continue;
    }
    if (const auto read = take_depth(out)) return *read;
    const TimeNs now_ns = clock_.now();
    const bool is_silent = last_image_ns_ == 0 ? now_ns - opened_ns_ > options_.first_image_ns
                                               : now_ns - last_image_ns_ > options_.stall_ns;
    if (link_->is_lost()) {
      ++counts_.unplugged;
      lose("the Kinect was pulled out");
    } else if (is_silent) {
      ++counts_.stalled;
      // One that is opened, and silent again, is no better than one that cannot be opened.
      const bool was_ever_alive = last_image_ns_ != 0;
      lose("the Kinect fell silent");
      if (!was_ever_alive) {
        next_try_ns_ = clock_.now() + retry_ns_;
        retry_ns_ = std::min(2 * retry_ns_, options_.last_retry_ns);
      }
    } else {
      clock_.sleep_until(now_ns + options_.poll_ns);
    }
  }
  return {CameraEvent::end, {}};
}

std::optional<CameraRead> KinectCamera::take_depth(Frame& out) {
  ImageIntake::Taken depth;
  if (!intake_.try_take(ImageKind::depth, depth)) return std::nullopt;
  last_image_ns_ = clock_.now();
  // Numbers that fall, or leap, are those of a sensor that began anew.
  const std::uint32_t step = last_index_ ? depth.index - *last_index_ : 1;
  const std::uint64_t missed = step >= 1 && step < 1000 ? step - 1 : 0;
  counts_.missed += missed;
  sequence_ += 1 + missed;
  last_index_ = depth.index;
  out.sequence = sequence_;
  out.has_colour = false;
  if (depth.fault != ImageFault::none) {
    intake_.release(ImageKind::depth, depth);
    publish();
    const bool is_size = depth.fault == ImageFault::wrong_size;
    return CameraRead{CameraEvent::dropped, is_size ? DropReason::wrong_size : DropReason::unreadable_depth};
  }
  retry_ns_ = options_.first_retry_ns;
  out.stamp_ns = stamps_->update(depth.device_ticks, depth.arrived_ns);
  if (has_stamp_) out.stamp_ns = std::max(out.stamp_ns, last_stamp_ns_ + 1);
  has_stamp_ = true;
  last_stamp_ns_ = out.stamp_ns;
  fill_depth(intake_.depth(depth), out.depth.get());
  intake_.release(ImageKind::depth, depth);
  add_colour(depth.device_ticks, out);
  ++counts_.frames;
  counts_.colourless += out.has_colour ? 0 : 1;
  publish();
  return CameraRead{CameraEvent::frame, {}};
}

void KinectCamera::fill_depth(const std::uint16_t* reported_mm, std::uint16_t* out_mm) {
  const std::size_t count = corrected_mm_.size();
  if (sensor_.is_registered) {
    depth_table_.apply(reported_mm, count, out_mm);
  } else {
    depth_table_.apply(reported_mm, count, corrected_mm_.data());
    registration_.apply(corrected_mm_.data(), out_mm);
  }
  if (!sensor_.is_mirrored) return;
  for (int v = 0; v < kHeight_px; ++v) std::reverse(out_mm + v * kWidth_px, out_mm + (v + 1) * kWidth_px);
}

void KinectCamera::add_colour(std::uint64_t depth_ticks, Frame& out) {
  const std::uint8_t* const rgb = colours_.pick(depth_ticks, options_.colour_within_ns);
  if (rgb == nullptr) return;
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(kWidth_px);
  if (!sensor_.is_mirrored) {
    std::memcpy(out.rgb.get(), rgb, row_bytes * kHeight_px);
  } else {
    for (std::size_t v = 0; v < kHeight_px; ++v) {
      for (std::size_t u = 0; u < kWidth_px; ++u) {
        std::memcpy(out.rgb.get() + v * row_bytes + 3 * u, rgb + v * row_bytes + 3 * (kWidth_px - 1 - u), 3);
      }
    }
  }
  out.has_colour = true;
}

void KinectCamera::publish() {
  counts_.is_open = is_open_;
  counts_.doubtful_stamps = stamps_ ? stamps_->doubtful() : 0;
  counts_.bad_depth = counts_.bad_colour = 0;
  for (std::size_t fault = 1; fault < kImageFaults; ++fault) {
    counts_.bad_depth += intake_.faults(ImageKind::depth, static_cast<ImageFault>(fault));
    counts_.bad_colour += intake_.faults(ImageKind::colour, static_cast<ImageFault>(fault));
  }
  counts_.depth_overruns = intake_.overruns(ImageKind::depth);
  counts_.colour_overruns = intake_.overruns(ImageKind::colour);
  published_.write(counts_);
}

KinectCounts KinectCamera::counts() const {
  KinectCounts counts;
  (void)published_.read(counts);
  return counts;
}

}  // namespace g3d::hal::kinect
