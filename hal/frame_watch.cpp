// SPDX-License-Identifier: Apache-2.0
#include "hal/frame_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace g3d::hal {
namespace {

constexpr TimeNs kAhead_ns = 50'000'000;  // stamps of a clock that is read in another thread
constexpr std::size_t kMinPairs = 100;    // fewer say nothing
// Depth edges and oblique walls make a few in a hundred; noise makes nine in ten.
constexpr double kMaxRoughPart = 0.5;

struct Summary {
  std::uint64_t digest = 14695981039346656037ULL;  // FNV-1a over readings
  std::size_t readings = 0;
  std::size_t pairs = 0;
  std::size_t rough_pairs = 0;
};

Summary summarise(const Frame& frame, const CameraModel& camera) {
  Summary s;
  const auto width = static_cast<std::size_t>(camera.width_px);
  for (std::size_t row = 0; row < camera.pixel_count(); row += width) {
    int left = 0;
    for (std::size_t u = 0; u < width; ++u) {
      const int depth = frame.depth[row + u];
      s.digest = (s.digest ^ static_cast<std::uint64_t>(depth)) * 1099511628211ULL;
      s.readings += depth != 0;
      const bool is_pair = left != 0 && depth != 0;
      s.pairs += is_pair;
      s.rough_pairs += is_pair && std::abs(depth - left) * 10 > std::min(depth, left);
      left = depth;
    }
  }
  return s;
}

}  // namespace

const char* to_string(FrameFault fault) {
  switch (fault) {
    case FrameFault::none:
      return "none";
    case FrameFault::old:
      return "old";
    case FrameFault::stuck:
      return "stuck";
    case FrameFault::garbage:
      return "garbage";
    case FrameFault::count_:
      break;
  }
  return "unknown";
}

FrameFault FrameWatch::check(const Frame& frame, const CameraModel& camera, const PlanarPose& T_world_base,
                             TimeNs now_ns) {
  const FrameFault fault = look(frame, camera, T_world_base, now_ns);
  ++counts_[static_cast<std::size_t>(fault)];
  return fault;
}

FrameFault FrameWatch::look(const Frame& frame, const CameraModel& camera, const PlanarPose& T_world_base,
                            TimeNs now_ns) {
  const bool repeats = had_frame_ && frame.stamp_ns <= last_stamp_ns_;
  if (repeats || now_ns - frame.stamp_ns > options_.max_age_ns || frame.stamp_ns - now_ns > kAhead_ns) {
    return FrameFault::old;
  }
  last_stamp_ns_ = frame.stamp_ns;
  const Summary summary = summarise(frame, camera);
  const bool stuck = is_stuck(summary.digest, T_world_base);
  had_frame_ = true;
  if (summary.readings == 0) return FrameFault::none;
  if (stuck) return FrameFault::stuck;
  const double rough = static_cast<double>(summary.rough_pairs), pairs = static_cast<double>(summary.pairs);
  return summary.pairs >= kMinPairs && rough > kMaxRoughPart * pairs ? FrameFault::garbage : FrameFault::none;
}

bool FrameWatch::is_stuck(std::uint64_t digest, const PlanarPose& T_world_base) {
  if (!had_frame_ || digest != last_digest_) {
    last_digest_ = digest;
    first_equal_ = T_world_base;
    return false;
  }
  const double dx_m = T_world_base.x_m - first_equal_.x_m, dy_m = T_world_base.y_m - first_equal_.y_m;
  const double turn_rad = std::remainder(T_world_base.heading_rad - first_equal_.heading_rad, 2.0 * std::numbers::pi);
  return dx_m * dx_m + dy_m * dy_m > options_.moved_m * options_.moved_m || std::abs(turn_rad) > options_.moved_rad;
}

}  // namespace g3d::hal
