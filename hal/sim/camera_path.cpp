// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/camera_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "hal/sim/plain_trig.hpp"
#include "hal/sim/text_fields.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kYaw = 3;
constexpr double kMaxTime_s = 1e6;

using Quaternion = std::array<double, 4>;  // x y z w

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

/// Into (-180, 180].
double wrapped_deg(double angle_deg) {
  double rest = std::fmod(angle_deg, 360.0);
  if (rest > 180.0) rest -= 360.0;
  if (rest <= -180.0) rest += 360.0;
  return rest;
}

/// Slope between two secants: none at an extremum, else their harmonic mean weighted by the neighbouring intervals.
double monotone_slope(double h0, double secant0, double h1, double secant1) {
  if (secant0 * secant1 <= 0.0) return 0.0;
  const double w0 = 2 * h1 + h0;
  const double w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / secant0 + w1 / secant1);
}

TimeNs to_ns(double t_s) { return static_cast<TimeNs>(std::llround(t_s * 1e9)); }

}  // namespace

Pose camera_pose(const std::array<double, 3>& eye_m, double yaw_deg, double pitch_deg) {
  const SinCos half_yaw = sin_cos_deg(yaw_deg / 2);
  // A positive turn about y (left) points the nose down.
  const SinCos half_pitch = sin_cos_deg(-pitch_deg / 2);
  constexpr Quaternion kBodyToOptical = {-0.5, 0.5, -0.5, 0.5};
  const Quaternion turn = product({0, 0, half_yaw.sin, half_yaw.cos}, {0, half_pitch.sin, 0, half_pitch.cos});
  return {eye_m, product(turn, kBodyToOptical)};
}

CameraPath::CameraPath(const std::vector<PathWaypoint>& waypoints) {
  assert(!waypoints.empty());
  knots_.reserve(waypoints.size());
  for (const PathWaypoint& w : waypoints) {
    Knot knot{w.t_s, w.x_y_z_yaw_pitch, {}};
    if (!knots_.empty()) {
      const double before = knots_.back().value[kYaw];
      knot.value[kYaw] = before + wrapped_deg(knot.value[kYaw] - before);
    }
    knots_.push_back(knot);
  }
  for (std::size_t i = 1; i + 1 < knots_.size(); ++i) {
    const double h0 = knots_[i].t_s - knots_[i - 1].t_s;
    const double h1 = knots_[i + 1].t_s - knots_[i].t_s;
    for (std::size_t k = 0; k < 5; ++k) {
      knots_[i].slope[k] = monotone_slope(h0, (knots_[i].value[k] - knots_[i - 1].value[k]) / h0, h1,
                                          (knots_[i + 1].value[k] - knots_[i].value[k]) / h1);
    }
  }
}

TimeNs CameraPath::begin_ns() const { return to_ns(knots_.front().t_s); }
TimeNs CameraPath::end_ns() const { return to_ns(knots_.back().t_s); }

Pose CameraPath::pose_at(TimeNs time_ns) const {
  const double t_s = static_cast<double>(time_ns) / 1e9;
  const auto next =
      std::upper_bound(knots_.begin(), knots_.end(), t_s, [](double t, const Knot& k) { return t < k.t_s; });
  std::array<double, 5> v;
  if (next == knots_.begin()) {
    v = knots_.front().value;
  } else if (next == knots_.end()) {
    v = knots_.back().value;
  } else {
    // Cubic Hermite between the two knots.
    const Knot& a = *(next - 1);
    const Knot& b = *next;
    const double h = b.t_s - a.t_s;
    const double s = (t_s - a.t_s) / h;
    const double rise = s * s * (3 - 2 * s);
    for (std::size_t k = 0; k < 5; ++k) {
      v[k] = a.value[k] + (b.value[k] - a.value[k]) * rise +
             h * (a.slope[k] * s * (1 - s) * (1 - s) - b.slope[k] * s * s * (1 - s));
    }
  }
  return camera_pose({v[0], v[1], v[2]}, v[3], v[4]);
}

CameraPath CameraPath::laps(int count) const {
  const double period_s = knots_.back().t_s - knots_.front().t_s;
  std::vector<PathWaypoint> waypoints;
  waypoints.reserve(knots_.size() * static_cast<std::size_t>(count));
  for (int lap = 0; lap < count; ++lap) {
    // The end of one lap is the beginning of the next.
    for (std::size_t i = lap == 0 ? 0 : 1; i < knots_.size(); ++i) {
      waypoints.push_back({knots_[i].t_s + lap * period_s, knots_[i].value});
    }
  }
  return CameraPath(waypoints);
}

Result<CameraPath> parse_camera_path(std::string_view text, std::string_view file) {
  struct Column {
    std::string_view name;
    double low;
    double high;
  };
  static constexpr std::array<Column, 6> kColumns = {{{"t_s", 0.0, kMaxTime_s},
                                                      {"x", -kMaxCoordinate_m, kMaxCoordinate_m},
                                                      {"y", -kMaxCoordinate_m, kMaxCoordinate_m},
                                                      {"z", -kMaxCoordinate_m, kMaxCoordinate_m},
                                                      {"yaw_deg", -36000.0, 36000.0},
                                                      {"pitch_deg", -90.0, 90.0}}};
  const auto lines = split_lines(text, file);
  if (!lines) return lines.error();
  std::vector<PathWaypoint> waypoints;
  for (const TextLine& line : lines.value()) {
    if (line.words().size() != kColumns.size()) {
      return line.error(
          Reason::malformed,
          fmt::format("a waypoint is six numbers: t_s x y z yaw_deg pitch_deg; found {}", line.words().size()));
    }
    std::array<double, 6> n{};
    for (std::size_t i = 0; i < kColumns.size(); ++i) {
      const auto value = line.number_in(line.words()[i], kColumns[i].name, kColumns[i].low, kColumns[i].high);
      if (!value) return value.error();
      n[i] = value.value();
    }
    if (!waypoints.empty() && n[0] < waypoints.back().t_s + 1e-3) {
      return line.error(Reason::malformed, "t_s must be at least a millisecond later than on the waypoint before");
    }
    if (waypoints.size() == kMaxPathWaypoints) {
      return line.error(Reason::too_large, fmt::format("more than {} waypoints", kMaxPathWaypoints));
    }
    waypoints.push_back({n[0], {n[1], n[2], n[3], n[4], n[5]}});
  }
  if (waypoints.empty()) {
    return Error{Reason::malformed,
                 fmt::format("{}: no waypoint in it; one per line: t_s x y z yaw_deg pitch_deg", file)};
  }
  return CameraPath(waypoints);
}

}  // namespace g3d::hal
