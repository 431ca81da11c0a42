// SPDX-License-Identifier: Apache-2.0
#include "nav/exploration_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/image/file_bytes.hpp"
#include "hal/image/png_writer.hpp"

namespace g3d::nav {
namespace {

constexpr int kWidth_px = 1200;
constexpr int kMargin_px = 30;
constexpr int kPanelWidth_px = kWidth_px - 2 * kMargin_px;
constexpr int kMostPanelHeight_px = 780;
constexpr int kTitle_px = 40;
constexpr int kLegend_px = 44;
constexpr int kChart_px = 260;
constexpr int kAxisRoom_px = 62;  // for the numbers left of the curve
constexpr int kEdge_cells = 4;    // around what is known

constexpr Colour kPaper{250, 250, 248};
constexpr Colour kInk{44, 48, 56};
constexpr Colour kFaint{214, 216, 220};
constexpr Colour kUnknown{222, 224, 228};
constexpr Colour kFree{255, 255, 255};
constexpr Colour kWall{58, 63, 73};
constexpr Colour kFrontier{230, 0, 126};
constexpr Colour kHome{20, 150, 70};
constexpr std::array kOverTime = {Colour{36, 92, 200}, Colour{20, 168, 168}, Colour{240, 160, 20}, Colour{214, 50, 30}};

Colour colour_at(double fraction) {
  const double place = std::clamp(fraction, 0.0, 1.0) * (kOverTime.size() - 1);
  const auto left = std::min(static_cast<std::size_t>(place), kOverTime.size() - 2);
  return mix(kOverTime[left], kOverTime[left + 1], place - static_cast<double>(left));
}

/// Where on the picture which part of the floor is.
struct Plan {
  Cell first;  ///< lower left
  int columns = 0, rows = 0;
  double cell_px = 1.0;
  int left_px = 0, top_px = 0;
  int width_px = kPanelWidth_px, height_px = kMostPanelHeight_px / 2;

  explicit Plan(const CellGrid<CellState>& ground) {
    Cell low{ground.columns, ground.rows};
    Cell high{-1, -1};
    for (std::size_t i = 0; i < ground.cells.size(); ++i) {
      if (ground.cells[i] == CellState::unknown) continue;
      const Cell c = ground.cell(i);
      low = {std::min(low.x, c.x), std::min(low.y, c.y)};
      high = {std::max(high.x, c.x), std::max(high.y, c.y)};
    }
    left_px = kMargin_px;
    top_px = kTitle_px + kMargin_px / 2;
    if (high.x < 0) return;
    first = {low.x - kEdge_cells, low.y - kEdge_cells};
    columns = high.x - low.x + 1 + 2 * kEdge_cells;
    rows = high.y - low.y + 1 + 2 * kEdge_cells;
    cell_px = std::min(kPanelWidth_px / static_cast<double>(columns), kMostPanelHeight_px / static_cast<double>(rows));
    width_px = static_cast<int>(columns * cell_px);
    height_px = static_cast<int>(rows * cell_px);
    left_px += (kPanelWidth_px - width_px) / 2;
  }
  [[nodiscard]] int bottom_px() const { return top_px + height_px; }
  /// Continuous cell coordinates to the picture.
  [[nodiscard]] PointPx place(double x_cells, double y_cells) const {
    return {left_px + (x_cells - first.x) * cell_px, bottom_px() - (y_cells - first.y) * cell_px};
  }
  [[nodiscard]] PointPx place_m(const CellGrid<CellState>& ground, double x_m, double y_m) const {
    return place((x_m - ground.origin_x_m) / ground.resolution_m, (y_m - ground.origin_y_m) / ground.resolution_m);
  }
};

void draw_ground(Canvas& canvas, const Plan& plan, const CellGrid<CellState>& ground) {
  for (int y = 0; y < plan.height_px; ++y) {
    for (int x = 0; x < plan.width_px; ++x) {
      const Cell c{plan.first.x + static_cast<int>((x + 0.5) / plan.cell_px),
                   plan.first.y + static_cast<int>((plan.height_px - y - 0.5) / plan.cell_px)};
      const CellState state = ground.contains(c) ? ground.at(c) : CellState::unknown;
      const Colour& colour = state == CellState::occupied ? kWall : state == CellState::free ? kFree : kUnknown;
      canvas.set(plan.left_px + x, plan.top_px + y, colour);
    }
  }
}

void draw_home(Canvas& canvas, const PointPx& place) {
  canvas.disc(place, 9.0, kFree);
  canvas.disc(place, 7.0, kHome);
}

void draw_robot(Canvas& canvas, const PointPx& place) {
  canvas.disc(place, 6.0, kInk);
  canvas.disc(place, 3.5, colour_at(1.0));
}

void draw_way(Canvas& canvas, const Plan& plan, const ExplorationPicture& picture) {
  const auto place = [&](std::size_t i) {
    const auto& at_m = picture.trajectory[i].translation_m;
    return plan.place_m(*picture.ground, at_m[0], at_m[1]);
  };
  const std::size_t count = picture.trajectory.size();
  for (std::size_t i = 1; i < count; ++i) {
    canvas.line(place(i - 1), place(i), 2.2, colour_at(static_cast<double>(i) / static_cast<double>(count)));
  }
  draw_home(canvas, plan.place_m(*picture.ground, picture.home.x_m, picture.home.y_m));
  if (count > 0) draw_robot(canvas, place(count - 1));
}

/// The largest of 1, 2 and 5 times a power of ten that is no more than `limit`.
double round_below(double limit) {
  const double step = std::pow(10.0, std::floor(std::log10(std::max(1e-6, limit))));
  return step * (limit >= 5.0 * step ? 5.0 : limit >= 2.0 * step ? 2.0 : 1.0);
}

void draw_legend(Canvas& canvas, const Plan& plan, double cell_m) {
  const int y = plan.bottom_px() + 14;
  const double middle = y + 7.0;
  int x = kMargin_px;
  draw_home(canvas, {x + 8.0, middle});
  canvas.text(x + 24, y, "home", kInk);
  x += 110;
  draw_robot(canvas, {x + 8.0, middle});
  canvas.text(x + 22, y, "robot", kInk);
  x += 120;
  for (int i = 0; i < 90; ++i) canvas.fill(x + i, y + 5, 1, 4, colour_at(i / 89.0));
  canvas.text(x + 100, y, "way, first to last", kInk);
  x += 350;
  canvas.disc({x + 6.0, middle}, 4.0, kFrontier);
  canvas.text(x + 18, y, "frontier left", kInk);
  const double bar_m = round_below(180.0 / plan.cell_px * cell_m);
  const int bar_px = static_cast<int>(bar_m / cell_m * plan.cell_px);
  const std::string length = fmt::format("{} m", bar_m);
  x = kWidth_px - kMargin_px - bar_px;
  canvas.fill(x, y + 5, bar_px, 4, kInk);
  canvas.text(x - 12 - Canvas::text_width_px(length), y, length, kInk);
}

void draw_curve(Canvas& canvas, int top_px, const ExplorationPicture& picture) {
  const int left = kMargin_px + kAxisRoom_px;
  const int width = kWidth_px - kMargin_px - left - 10;
  const int height = kChart_px - 70;
  const double end_s = std::max({1.0, picture.time_s, picture.coverage.back().time_s});
  const auto x_of = [&](double time_s) { return left + time_s / end_s * width; };
  const auto y_of = [&](double fraction) { return top_px + (1.0 - fraction) * height; };
  for (const int percent : {0, 25, 50, 75, 100}) {
    const int y = static_cast<int>(y_of(percent / 100.0));
    canvas.fill(left, y, width, 1, kFaint);
    const std::string label = fmt::format("{} %", percent);
    canvas.text(left - 10 - Canvas::text_width_px(label), y - 7, label, kInk);
  }
  const double step_s = std::max(1.0, round_below(end_s / 5.0));
  for (int i = 0; i * step_s <= end_s; ++i) {
    const int x = static_cast<int>(x_of(i * step_s));
    canvas.fill(x, top_px, 1, height, kFaint);
    const std::string label = fmt::format("{}", i * step_s);
    canvas.text(x - Canvas::text_width_px(label) / 2, top_px + height + 10, label, kInk);
  }
  canvas.fill(left, top_px, 2, height, kInk);
  canvas.fill(left, top_px + height, width, 2, kInk);
  const std::string axis = "share seen of what can be seen, over seconds";
  canvas.text(left + (width - Canvas::text_width_px(axis)) / 2, top_px + height + 34, axis, kInk);
  PointPx before{x_of(0.0), y_of(0.0)};
  for (const CoverageSample& sample : picture.coverage) {
    const PointPx here{x_of(sample.time_s), y_of(std::clamp(sample.fraction, 0.0, 1.0))};
    canvas.line(before, here, 3.0, colour_at(sample.time_s / end_s));
    before = here;
  }
}

}  // namespace

Canvas draw_exploration(const ExplorationPicture& picture) {
  const CellGrid<CellState>& ground = *picture.ground;
  const Plan plan(ground);
  const int map_bottom = plan.bottom_px() + kLegend_px;
  Canvas canvas({kWidth_px, map_bottom + (picture.coverage.empty() ? 0 : kChart_px)}, kPaper);
  canvas.text(kMargin_px, kMargin_px / 2 + 4, picture.title, kInk);
  draw_ground(canvas, plan, ground);
  for (const std::uint32_t i : picture.frontier_cells) {
    const Cell c = ground.cell(i);
    canvas.disc(plan.place(c.x + 0.5, c.y + 0.5), std::max(2.0, 0.5 * plan.cell_px), kFrontier);
  }
  draw_way(canvas, plan, picture);
  draw_legend(canvas, plan, ground.resolution_m);
  if (!picture.coverage.empty()) draw_curve(canvas, map_bottom + kMargin_px / 2, picture);
  return canvas;
}

hal::Result<std::uint64_t> write_exploration_picture(const ExplorationPicture& picture, const std::string& path) {
  const Canvas canvas = draw_exploration(picture);
  const auto png = hal::encode_png_rgb(canvas.size(), canvas.rgb());
  if (!png) return png.error();
  if (const auto written = hal::write_file_atomic(path, png.value()); !written) return written.error();
  return static_cast<std::uint64_t>(png.value().size());
}

}  // namespace g3d::nav
