// SPDX-License-Identifier: Apache-2.0
// A world made of analytic solids, for the simulated camera: boxes, spheres, cylinders and cones that stand upright
// (turned about z only), what is composed of them (stairs, shelves, rooms), people that walk, and walls on a 2D grid.
// World frame: x forward, y left, z up, metres. Filled once, then only read: any number of threads may share it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/grid_walls.hpp"
#include "hal/twist.hpp"

namespace g3d::hal {

struct Rgb {
  std::uint8_t r = 200;
  std::uint8_t g = 200;
  std::uint8_t b = 200;
  bool operator==(const Rgb&) const = default;
};

enum class Texture : std::uint8_t {
  plain,
  checker,  ///< squares of texture_size_m in all three local axes
  stripes,  ///< bands of texture_size_m across the longer horizontal side; on upright round solids, across the height
};

struct Material {
  Rgb colour;
  Rgb second_colour{120, 120, 120};
  Texture texture = Texture::plain;
  float texture_size_m = 0.5F;
  bool dark = false;   ///< swallows the infrared dots: has a colour, but no depth reading
  bool glass = false;  ///< lets the infrared pass: depth is what stands behind, colour is tinted
};

enum class Shape : std::uint8_t { box, sphere, cylinder, cone };

/// One solid. `centre_m` and `half_m` are those of its upright bounding box, turned by yaw about its centre.
struct Primitive {
  Shape shape = Shape::box;
  std::array<float, 3> centre_m{};
  std::array<float, 3> half_m{};
  float cos_yaw = 1.0F;
  float sin_yaw = 0.0F;
  float radius_low_m = 0.0F;   ///< sphere and cylinder: the radius; cone: at its underside
  float radius_high_m = 0.0F;  ///< cone: at its upper side, 0 for a pointed one
  Material material;
  std::int32_t mover = -1;  ///< index of the Mover that carries it, -1: it stands still
};

/// Where something that moves is: straight lines between waypoints, at rest before the first and after the last.
struct Mover {
  struct Waypoint {
    double t_s = 0.0;
    double x_m = 0.0;
    double y_m = 0.0;
  };
  std::vector<Waypoint> waypoints;  ///< at least one, ascending t_s
};

/// Where movers stand when something else than the clock moves them: one place per mover.
using MoverPlaces = std::span<const std::array<float, 2>>;

/// Everything from outside is bounded by these.
inline constexpr std::size_t kMaxPrimitives = 4096;
inline constexpr std::size_t kMaxMovers = 64;
inline constexpr std::size_t kMaxMoverWaypoints = 1024;
inline constexpr std::size_t kMaxStarts = 64;
inline constexpr double kMaxCoordinate_m = 1000.0;
inline constexpr double kMinSize_m = 0.001;

class World {
 public:
  // (x, y) is the middle of the solid's plan, z its underside (a sphere's: its centre). Angles in degrees.
  void add_box(std::array<double, 3> at_m, std::array<double, 3> size_m, double yaw_deg, const Material& material);
  void add_sphere(std::array<double, 3> centre_m, double radius_m, const Material& material);
  void add_cylinder(std::array<double, 3> at_m, double radius_m, double height_m, const Material& material);
  void add_cone(std::array<double, 3> at_m, double radius_m, double height_m, double top_radius_m,
                const Material& material);
  /// Solid steps that climb along local +x; `at` is the middle of the lowest step's front edge on the floor.
  void add_stairs(std::array<double, 3> at_m, double width_m, double run_m, double rise_m, int steps, double yaw_deg,
                  const Material& material);
  /// Open unit of `boards` boards between two sides, width along local x, depth along y. 2 cm boards, no back.
  void add_shelves(std::array<double, 3> at_m, std::array<double, 3> size_m, int boards, double yaw_deg,
                   const Material& material);
  /// Four walls, floor and (optional) ceiling around an inner space of `size`; the walls stand outside of it.
  void add_room(std::array<double, 3> at_m, std::array<double, 3> inner_size_m, double thickness_m,
                const Material& walls, const Material& floor, const std::optional<Material>& ceiling);
  /// Slab whose upper side is at z.
  void add_floor(std::array<double, 3> at_m, double size_x_m, double size_y_m, double thickness_m,
                 const Material& material);
  /// A walking cylinder with a spherical head; its feet are at the world's z = 0.
  void add_person(double height_m, double radius_m, const Material& material, Mover mover);
  /// An upright cylinder around wherever its mover is; `below_m` is its underside. Returns the index of its mover.
  std::size_t add_moving_cylinder(double below_m, double radius_m, double height_m, const Material& material);
  /// Where a robot may begin, in the order in which robots are put there.
  void add_start(const PlanarPose& T_world_base) { starts_.push_back(T_world_base); }
  void set_grid(GridWalls grid) { grid_ = std::move(grid); }

  [[nodiscard]] const std::vector<Primitive>& primitives() const { return primitives_; }
  [[nodiscard]] const std::vector<Mover>& movers() const { return movers_; }
  [[nodiscard]] const std::vector<PlanarPose>& starts() const { return starts_; }
  [[nodiscard]] const std::optional<GridWalls>& grid() const { return grid_; }
  /// Position of a mover at a time since the world's start.
  [[nodiscard]] std::array<float, 2> mover_at(std::size_t mover, TimeNs time_ns) const;
  /// The solid where it stands at that time.
  [[nodiscard]] Primitive placed(std::size_t index, TimeNs time_ns) const;
  [[nodiscard]] Primitive placed(std::size_t index, MoverPlaces places_m) const;

 private:
  std::vector<Primitive> primitives_;
  std::vector<Mover> movers_;
  std::vector<PlanarPose> starts_;
  std::optional<GridWalls> grid_;
};

}  // namespace g3d::hal
