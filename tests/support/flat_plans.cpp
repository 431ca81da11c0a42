// SPDX-License-Identifier: Apache-2.0
// Generated floor plans. Sizes are those of real buildings; every plan is enclosed by a wall.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "tests/support/flat_world.hpp"
#include "tests/support/sample_maps.hpp"

namespace g3d::tests {
namespace {

class Plan {
 public:
  Plan(double width_m, double height_m, std::uint64_t seed)
      : random(seed),
        solid_(0.05, 0.0, 0.0, static_cast<int>(std::lround(width_m / 0.05)),
               static_cast<int>(std::lround(height_m / 0.05)), 0),
        width_(width_m),
        height_(height_m) {
    fill(0, 0, width_m, 0.15);
    fill(0, height_m - 0.15, width_m, height_m);
    fill(0, 0, 0.15, height_m);
    fill(width_m - 0.15, 0, width_m, height_m);
  }

  void fill(double x0, double y0, double x1, double y1, std::uint8_t value = 1) {
    const auto cells = [](double v) { return static_cast<int>(std::lround(v / 0.05)); };
    for (int y = std::max(cells(y0), 0); y < std::min(cells(y1), solid_.rows); ++y) {
      for (int x = std::max(cells(x0), 0); x < std::min(cells(x1), solid_.columns); ++x) solid_.at({x, y}) = value;
    }
  }
  void wall_x(double x0, double x1, double y) { fill(x0, y - 0.075, x1, y + 0.075); }
  void wall_y(double x, double y0, double y1) { fill(x - 0.075, y0, x + 0.075, y1); }
  void door_x(double x, double y, double width) { fill(x - width / 2, y - 0.1, x + width / 2, y + 0.1, 0); }
  void door_y(double x, double y, double width) { fill(x - 0.1, y - width / 2, x + 0.1, y + width / 2, 0); }
  /// Furniture within a rectangle, along its walls or anywhere, never in the way of a margin around the doors.
  void furnish(double x0, double y0, double x1, double y1, int pieces, bool at_walls) {
    for (int n = 0; n < pieces; ++n) {
      double w = random.uniform(0.4, 1.5);
      double h = random.uniform(0.4, 0.8);
      if (random.below(2)) std::swap(w, h);
      double x = random.uniform(x0 + 0.1, std::max(x0 + 0.11, x1 - w - 0.1));
      double y = random.uniform(y0 + 0.1, std::max(y0 + 0.11, y1 - h - 0.1));
      if (at_walls) {
        switch (random.below(4)) {
          case 0:
            x = x0 + 0.05;
            break;
          case 1:
            x = x1 - w - 0.05;
            break;
          case 2:
            y = y0 + 0.05;
            break;
          default:
            y = y1 - h - 0.05;
            break;
        }
      }
      fill(x, y, std::min(x + w, x1), std::min(y + h, y1));
    }
  }
  [[nodiscard]] nav::CellGrid<std::uint8_t> take() { return std::move(solid_); }
  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }

  Random random;

 private:
  nav::CellGrid<std::uint8_t> solid_;
  double width_;
  double height_;
};

void office(Plan& p) {
  const double low = p.height() / 2 - 1.0;
  const double high = p.height() / 2 + 1.0;
  p.wall_x(0, p.width(), low);
  p.wall_x(0, p.width(), high);
  for (const bool upper : {false, true}) {
    double x = 0.15;
    while (x < p.width() - 2.5) {
      const double next = std::min(x + p.random.uniform(3.0, 5.5), p.width() - 0.15);
      const double end = p.width() - next < 3.0 ? p.width() - 0.15 : next;
      const double y0 = upper ? high + 0.1 : 0.15;
      const double y1 = upper ? p.height() - 0.15 : low - 0.1;
      if (end < p.width() - 1) p.wall_y(end, y0 - 0.1, y1 + 0.1);
      p.furnish(x + 0.1, upper ? y0 + 1.2 : y0, end - 0.1, upper ? y1 : y1 - 1.2,
                3 + static_cast<int>(p.random.below(3)), true);
      p.door_x(p.random.uniform(x + 0.8, end - 0.8), upper ? high : low, 0.9);
      x = end;
    }
  }
}

void corridor_loop(Plan& p) {
  p.fill(2.0, 2.0, p.width() - 2.0, p.height() - 2.0);
  p.fill(p.width() / 2 - 0.9, 2.0, p.width() / 2 + 0.9, p.height() - 2.0, 0);
  for (int n = 0; n < 5; ++n) {
    const double x = p.random.uniform(2.5, p.width() - 4.5);
    p.fill(x, 2.0, x + 1.5, 3.2, 0);
    p.fill(p.width() - x - 1.5, p.height() - 3.4, p.width() - x, p.height() - 2.0, 0);
  }
}

void maze(Plan& p) {
  constexpr double kPitch_m = 1.6;
  const int columns = static_cast<int>(p.width() / kPitch_m);
  const int rows = static_cast<int>(p.height() / kPitch_m);
  const auto left = [&](int i) { return i * kPitch_m + 0.075; };
  for (int i = 0; i <= columns; ++i) p.wall_y(left(i), 0, rows * kPitch_m + 0.15);
  for (int j = 0; j <= rows; ++j) p.wall_x(0, columns * kPitch_m + 0.15, left(j));
  p.fill(columns * kPitch_m + 0.15, 0, p.width(), p.height());
  p.fill(0, rows * kPitch_m + 0.15, p.width(), p.height());
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(columns * rows), 0);
  std::vector<int> stack{0};
  seen[0] = 1;
  const auto open = [&](int a, int b) {
    const int i = std::max(a % columns, b % columns);
    const int j = std::max(a / columns, b / columns);
    if (a / columns == b / columns) {
      p.fill(left(i) - 0.1, left(j) + 0.1, left(i) + 0.1, left(j + 1) - 0.1, 0);
    } else {
      p.fill(left(i) + 0.1, left(j) - 0.1, left(i + 1) - 0.1, left(j) + 0.1, 0);
    }
  };
  const auto neighbours = [&](int at, bool unseen) {
    std::vector<int> out;
    const int i = at % columns;
    const int j = at / columns;
    const auto add = [&](int n) {
      if (!unseen || !seen[static_cast<std::size_t>(n)]) out.push_back(n);
    };
    if (i > 0) add(at - 1);
    if (i < columns - 1) add(at + 1);
    if (j > 0) add(at - columns);
    if (j < rows - 1) add(at + columns);
    return out;
  };
  while (!stack.empty()) {
    const std::vector<int> next = neighbours(stack.back(), true);
    if (next.empty()) {
      stack.pop_back();
      continue;
    }
    const int n = next[p.random.below(static_cast<std::uint32_t>(next.size()))];
    open(stack.back(), n);
    seen[static_cast<std::size_t>(n)] = 1;
    stack.push_back(n);
  }
  for (int n = 0; n < columns * rows / 8; ++n) {
    const int at = static_cast<int>(p.random.below(static_cast<std::uint32_t>(columns * rows)));
    const std::vector<int> next = neighbours(at, false);
    open(at, next[p.random.below(static_cast<std::uint32_t>(next.size()))]);
  }
}

void house(Plan& p) {
  const double mx = p.random.uniform(5.0, 7.0);
  const double my = p.random.uniform(4.0, 6.0);
  const double nx = p.random.uniform(8.5, 9.5);
  p.wall_y(mx, 0, p.height());
  p.wall_x(0, mx, my);
  p.wall_x(mx, p.width(), my + 1.0);
  p.wall_y(nx, my + 1.0, p.height());
  p.furnish(0.15, 0.15, mx - 0.1, my - 0.1, 4, true);
  p.furnish(0.15, my + 0.1, mx - 0.1, p.height() - 0.15, 4, true);
  p.furnish(mx + 0.1, 0.15, p.width() - 0.15, my + 0.9, 4, true);
  p.furnish(mx + 1.5, 1.5, p.width() - 1.5, my - 0.5, 1, false);
  p.furnish(nx + 0.1, my + 1.1, p.width() - 0.15, p.height() - 0.15, 2, true);
  const auto clear_door_x = [&](double x, double y) {
    p.fill(x - 0.5, y - 0.9, x + 0.5, y + 0.9, 0);
    p.wall_x(x - 0.6, x + 0.6, y);
    p.door_x(x, y, 0.85);
  };
  const auto clear_door_y = [&](double x, double y) {
    p.fill(x - 0.9, y - 0.5, x + 0.9, y + 0.5, 0);
    p.wall_y(x, y - 0.6, y + 0.6);
    p.door_y(x, y, 0.85);
  };
  clear_door_y(mx, my / 2);
  clear_door_x(mx / 2, my);
  clear_door_x((mx + nx) / 2, my + 1.0);
  clear_door_y(nx, (my + 1.0 + p.height()) / 2);
}

void hall(Plan& p) {
  for (double x = 4.0; x < p.width() - 2; x += 4.0) {
    for (double y = 3.75; y < p.height() - 2; y += 3.75) {
      if (p.random.below(4) != 0) p.fill(x - 0.25, y - 0.25, x + 0.25, y + 0.25);
    }
  }
}

void narrow_doors(Plan& p) {
  for (int i = 1; i < 3; ++i) {
    p.wall_y(i * p.width() / 3, 0, p.height());
    p.wall_x(0, p.width(), i * p.height() / 3);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 2; ++j) {
      p.door_x((i + p.random.uniform(0.3, 0.7)) * p.width() / 3, (j + 1) * p.height() / 3, 0.50);
      if (i != 1 || j == 0) p.door_y((j + 1) * p.width() / 3, (i + p.random.uniform(0.3, 0.7)) * p.height() / 3, 0.55);
    }
  }
}

void lab(Plan& p) {
  for (int n = 0; n < 45; ++n) {
    const double w = p.random.uniform(0.15, 0.9);
    const double h = p.random.uniform(0.15, 0.9);
    const double x = p.random.uniform(0.3, p.width() - 1.2);
    const double y = p.random.uniform(0.3, p.height() - 1.2);
    p.fill(x, y, x + w, y + h);
  }
}

void warehouse(Plan& p) {
  for (double x = 2.2; x < p.width() - 2.5; x += 3.0) {
    const double gap = p.random.uniform(5.0, p.height() - 5.0);
    p.fill(x, 2.2, x + 1.0, gap - 0.8);
    p.fill(x, gap + 0.8, x + 1.0, p.height() - 2.2);
  }
}

}  // namespace

const std::vector<std::string_view>& flat_world_names() {
  static const std::vector<std::string_view> kNames = {"office", "corridor_loop", "maze", "house",
                                                       "hall",   "narrow_doors",  "lab",  "warehouse"};
  return kNames;
}

FlatWorld make_flat_world(std::string_view name, std::uint64_t variant) {
  struct Kind {
    std::string_view name;
    double width_m;
    double height_m;
    void (*draw)(Plan&);
  };
  static constexpr Kind kKinds[] = {{"office", 17, 11, office}, {"corridor_loop", 22, 12, corridor_loop},
                                    {"maze", 11, 11, maze},     {"house", 12, 10, house},
                                    {"hall", 16, 12, hall},     {"narrow_doors", 12, 12, narrow_doors},
                                    {"lab", 12, 10, lab},       {"warehouse", 16, 13, warehouse}};
  for (const Kind& kind : kKinds) {
    if (kind.name != name) continue;
    Plan plan(kind.width_m, kind.height_m, variant * 31 + kind.name.size());
    kind.draw(plan);
    return {std::string(name), plan.take()};
  }
  throw std::runtime_error("no such floor plan");
}

}  // namespace g3d::tests
