// SPDX-License-Identifier: Apache-2.0
#include "nav/floor_steps.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kFloor_m = 0.04;      // where a column begins, the floor is at most this far from where it should be
constexpr double kSame_m = 0.012;      // the floor goes on
constexpr double kFollow = 0.3;        // how fast the level follows: cameras are never mounted quite level
constexpr double kHidden_m = 0.35;     // of floor without a reading: then it is not the same floor any more
constexpr double kTop_m = 0.10;        // how far behind its front a step is looked at
constexpr std::size_t kConfirmed = 2;  // readings

bool is_obstacle_around(const CellGrid<CellState>& states, Cell at) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const Cell c{at.x + dx, at.y + dy};
      if (states.contains(c) && states.at(c) == CellState::occupied) return true;
    }
  }
  return false;
}

}  // namespace

FloorSteps::FloorSteps(const CellGrid<CellState>& like, const FloorStepsConfig& config)
    : config_(config),
      T_base_camera_(hal::to_transform(config.T_base_camera)),
      votes_(like.resolution_m, like.origin_x_m, like.origin_y_m, like.columns, like.rows, 0) {
  column_.reserve(kRows);
  changed_.reserve(static_cast<std::size_t>(kColumns) * kRows);
}

void FloorSteps::look(const hal::Frame& frame, const hal::CameraModel& camera, const CellGrid<CellState>& states,
                      const hal::PlanarPose& T_world_base) {
  changed_.clear();
  for (int i = 0; i < kColumns; ++i) {
    read_column(frame, camera, (2 * i + 1) * camera.width_px / (2 * kColumns));
    judge_column(states, T_world_base);
  }
}

void FloorSteps::read_column(const hal::Frame& frame, const hal::CameraModel& camera, int u) {
  column_.clear();
  const auto& r = T_base_camera_.rotation;
  const auto& eye = T_base_camera_.translation_m;
  const float right = (static_cast<float>(u) - camera.cx_px) / camera.fx_px;
  const int half = camera.height_px / 2;
  const int rows = std::min(kRows, camera.height_px - half);
  for (int i = 0; i < rows; ++i) {
    const int v = camera.height_px - 1 - i * half / rows;
    const std::uint16_t raw = frame.depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width_px) +
                                          static_cast<std::size_t>(u)];
    if (raw == 0) continue;
    const float z_m = static_cast<float>(raw) / camera.depth_units_per_metre;
    const float down = (static_cast<float>(v) - camera.cy_px) / camera.fy_px;
    Reading reading{};
    const auto dx_m = static_cast<double>(z_m * (r[0] * right + r[1] * down + r[2]));
    const auto dy_m = static_cast<double>(z_m * (r[3] * right + r[4] * down + r[5]));
    reading.distance_m = std::hypot(dx_m, dy_m);
    reading.height_m = static_cast<double>(eye[2] + z_m * (r[6] * right + r[7] * down + r[8]));
    reading.x_m = static_cast<double>(eye[0]) + dx_m;
    reading.y_m = static_cast<double>(eye[1]) + dy_m;
    if (reading.distance_m > config_.far_m) break;
    column_.push_back(reading);
  }
}

// Whether from this reading on the floor is another one, and no obstacle.
bool FloorSteps::goes_on(std::size_t first, double level_m) const {
  const bool is_up = column_[first].height_m > level_m;
  std::size_t confirmed = 0;
  for (std::size_t i = first; i < column_.size(); ++i) {
    if (column_[i].distance_m > column_[first].distance_m + kTop_m && confirmed >= kConfirmed) break;
    const double step_m = (column_[i].height_m - level_m) * (is_up ? 1.0 : -1.0);
    if (is_up && step_m > kMost_m) return false;
    if (step_m < kLeast_m) break;
    ++confirmed;
  }
  return confirmed >= kConfirmed;
}

Cell FloorSteps::cell_of(const Reading& reading, const hal::PlanarPose& pose) const {
  const double c = std::cos(pose.heading_rad);
  const double s = std::sin(pose.heading_rad);
  return votes_.cell_of(pose.x_m + c * reading.x_m - s * reading.y_m, pose.y_m + s * reading.x_m + c * reading.y_m);
}

void FloorSteps::judge_column(const CellGrid<CellState>& states, const hal::PlanarPose& pose) {
  if (column_.empty() || std::fabs(column_[0].height_m) > kFloor_m) return;
  double level_m = column_[0].height_m;
  Reading last = column_[0];
  for (std::size_t i = 1; i < column_.size(); ++i) {
    const Reading& reading = column_[i];
    if (std::fabs(reading.distance_m - last.distance_m) > kHidden_m) return;
    const double step_m = reading.height_m - level_m;
    if (std::fabs(step_m) < kSame_m) {
      level_m += kFollow * step_m;
      const Cell passed = cell_of(last, pose);
      if (!(passed == cell_of(reading, pose))) vote(passed, false);  // the cell before a step says nothing against it
      last = reading;
    } else if (std::fabs(step_m) >= kLeast_m) {
      if (!goes_on(i, level_m)) return;
      const Cell at = cell_of(step_m > 0.0 ? reading : last, pose);
      if (!is_obstacle_around(states, at) || is_step(at)) vote(at, true);
      return;
    }
  }
}

void FloorSteps::vote(Cell c, bool is_step_here) {
  if (!votes_.contains(c)) return;
  std::uint8_t& votes = votes_.at(c);
  const bool before = votes >= kStep;
  if (is_step_here) {
    votes = static_cast<std::uint8_t>(std::min<int>(votes + 2, kMostVotes));
  } else if (votes > 0) {
    --votes;
  }
  if ((votes >= kStep) != before) changed_.push_back(static_cast<std::uint32_t>(votes_.index(c)));
}

}  // namespace g3d::nav
