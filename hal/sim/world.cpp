// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/world.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "hal/sim/plain_trig.hpp"

namespace g3d::hal {
namespace {

constexpr double kShelfBoard_m = 0.02;

Primitive make(Shape shape, std::array<double, 3> centre_m, std::array<double, 3> size_m, const Material& material) {
  Primitive p;
  p.shape = shape;
  for (std::size_t k = 0; k < 3; ++k) {
    p.centre_m[k] = static_cast<float>(centre_m[k]);
    p.half_m[k] = static_cast<float>(size_m[k] / 2.0);
  }
  p.material = material;
  return p;
}

/// A point of a composed thing, given in that thing's own axes.
std::array<double, 3> local_to_world(const std::array<double, 3>& at_m, const SinCos& yaw, double x_m, double y_m,
                                     double z_m) {
  return {at_m[0] + yaw.cos * x_m - yaw.sin * y_m, at_m[1] + yaw.sin * x_m + yaw.cos * y_m, at_m[2] + z_m};
}

}  // namespace

void World::add_box(std::array<double, 3> at_m, std::array<double, 3> size_m, double yaw_deg,
                    const Material& material) {
  Primitive p = make(Shape::box, {at_m[0], at_m[1], at_m[2] + size_m[2] / 2.0}, size_m, material);
  const SinCos yaw = sin_cos_deg(yaw_deg);
  p.cos_yaw = static_cast<float>(yaw.cos);
  p.sin_yaw = static_cast<float>(yaw.sin);
  primitives_.push_back(p);
}

void World::add_sphere(std::array<double, 3> centre_m, double radius_m, const Material& material) {
  Primitive p = make(Shape::sphere, centre_m, {2 * radius_m, 2 * radius_m, 2 * radius_m}, material);
  p.radius_low_m = static_cast<float>(radius_m);
  primitives_.push_back(p);
}

void World::add_cylinder(std::array<double, 3> at_m, double radius_m, double height_m, const Material& material) {
  Primitive p = make(Shape::cylinder, {at_m[0], at_m[1], at_m[2] + height_m / 2.0},
                     {2 * radius_m, 2 * radius_m, height_m}, material);
  p.radius_low_m = static_cast<float>(radius_m);
  p.radius_high_m = static_cast<float>(radius_m);
  primitives_.push_back(p);
}

void World::add_cone(std::array<double, 3> at_m, double radius_m, double height_m, double top_radius_m,
                     const Material& material) {
  const double widest_m = std::max(radius_m, top_radius_m);
  Primitive p =
      make(Shape::cone, {at_m[0], at_m[1], at_m[2] + height_m / 2.0}, {2 * widest_m, 2 * widest_m, height_m}, material);
  p.radius_low_m = static_cast<float>(radius_m);
  p.radius_high_m = static_cast<float>(top_radius_m);
  primitives_.push_back(p);
}

void World::add_stairs(std::array<double, 3> at_m, double width_m, double run_m, double rise_m, int steps,
                       double yaw_deg, const Material& material) {
  const SinCos yaw = sin_cos_deg(yaw_deg);
  for (int i = 0; i < steps; ++i) {
    add_box(local_to_world(at_m, yaw, (i + 0.5) * run_m, 0.0, 0.0), {run_m, width_m, (i + 1) * rise_m}, yaw_deg,
            material);
  }
}

void World::add_shelves(std::array<double, 3> at_m, std::array<double, 3> size_m, int boards, double yaw_deg,
                        const Material& material) {
  assert(boards >= 2);
  const SinCos yaw = sin_cos_deg(yaw_deg);
  const double side_m = (size_m[0] - kShelfBoard_m) / 2.0;
  for (const double x_m : {-side_m, side_m}) {
    add_box(local_to_world(at_m, yaw, x_m, 0.0, 0.0), {kShelfBoard_m, size_m[1], size_m[2]}, yaw_deg, material);
  }
  for (int i = 0; i < boards; ++i) {
    const double z_m = (size_m[2] - kShelfBoard_m) * i / (boards - 1);
    add_box(local_to_world(at_m, yaw, 0.0, 0.0, z_m), {size_m[0] - 2 * kShelfBoard_m, size_m[1], kShelfBoard_m},
            yaw_deg, material);
  }
}

void World::add_room(std::array<double, 3> at_m, std::array<double, 3> inner_size_m, double thickness_m,
                     const Material& walls, const Material& floor, const std::optional<Material>& ceiling) {
  const double sx = inner_size_m[0];
  const double sy = inner_size_m[1];
  const double sz = inner_size_m[2];
  const double out_x = (sx + thickness_m) / 2.0;
  const double out_y = (sy + thickness_m) / 2.0;
  for (const double side : {-1.0, 1.0}) {
    add_box({at_m[0] + side * out_x, at_m[1], at_m[2]}, {thickness_m, sy + 2 * thickness_m, sz}, 0.0, walls);
    add_box({at_m[0], at_m[1] + side * out_y, at_m[2]}, {sx, thickness_m, sz}, 0.0, walls);
  }
  add_floor(at_m, sx + 2 * thickness_m, sy + 2 * thickness_m, thickness_m, floor);
  if (ceiling) {
    add_box({at_m[0], at_m[1], at_m[2] + sz}, {sx + 2 * thickness_m, sy + 2 * thickness_m, thickness_m}, 0.0, *ceiling);
  }
}

void World::add_floor(std::array<double, 3> at_m, double size_x_m, double size_y_m, double thickness_m,
                      const Material& material) {
  add_box({at_m[0], at_m[1], at_m[2] - thickness_m}, {size_x_m, size_y_m, thickness_m}, 0.0, material);
}

void World::add_person(double height_m, double radius_m, const Material& material, Mover mover) {
  assert(!mover.waypoints.empty());
  const double head_radius_m = std::min(0.12, height_m / 4.0);
  const std::size_t first = primitives_.size();
  add_cylinder({0, 0, 0}, radius_m, height_m - 2 * head_radius_m, material);
  Material skin = material;
  skin.colour = {226, 188, 160};
  skin.texture = Texture::plain;
  skin.dark = false;
  add_sphere({0, 0, height_m - head_radius_m}, head_radius_m, skin);
  for (std::size_t i = first; i < primitives_.size(); ++i) {
    primitives_[i].mover = static_cast<std::int32_t>(movers_.size());
  }
  movers_.push_back(std::move(mover));
}

std::size_t World::add_moving_cylinder(double below_m, double radius_m, double height_m, const Material& material) {
  add_cylinder({0, 0, below_m}, radius_m, height_m, material);
  primitives_.back().mover = static_cast<std::int32_t>(movers_.size());
  movers_.push_back({.waypoints = {{}}});
  return movers_.size() - 1;
}

std::array<float, 2> World::mover_at(std::size_t mover, TimeNs time_ns) const {
  const auto& points = movers_[mover].waypoints;
  const double t_s = static_cast<double>(time_ns) / 1e9;
  const auto next =
      std::upper_bound(points.begin(), points.end(), t_s, [](double t, const Mover::Waypoint& w) { return t < w.t_s; });
  if (next == points.begin()) return {static_cast<float>(points.front().x_m), static_cast<float>(points.front().y_m)};
  if (next == points.end()) return {static_cast<float>(points.back().x_m), static_cast<float>(points.back().y_m)};
  const Mover::Waypoint& a = *(next - 1);
  const Mover::Waypoint& b = *next;
  const double fraction = (t_s - a.t_s) / (b.t_s - a.t_s);
  return {static_cast<float>(a.x_m + (b.x_m - a.x_m) * fraction),
          static_cast<float>(a.y_m + (b.y_m - a.y_m) * fraction)};
}

Primitive World::placed(std::size_t index, TimeNs time_ns) const {
  Primitive p = primitives_[index];
  if (p.mover >= 0) {
    const auto at_m = mover_at(static_cast<std::size_t>(p.mover), time_ns);
    p.centre_m[0] += at_m[0];
    p.centre_m[1] += at_m[1];
  }
  return p;
}

Primitive World::placed(std::size_t index, MoverPlaces places_m) const {
  Primitive p = primitives_[index];
  if (p.mover >= 0) {
    p.centre_m[0] += places_m[static_cast<std::size_t>(p.mover)][0];
    p.centre_m[1] += places_m[static_cast<std::size_t>(p.mover)][1];
  }
  return p;
}

}  // namespace g3d::hal
