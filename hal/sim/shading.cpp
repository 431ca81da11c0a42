// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/shading.hpp"

#include <cmath>

namespace g3d::hal {
namespace {

using Vec = std::array<float, 3>;

constexpr Vec kMainLamp = {0.36F, 0.48F, 0.80F};  // unit vectors towards the lamps
constexpr Vec kSecondLamp = {-0.64F, -0.48F, 0.60F};
constexpr float kAmbient = 0.60F;
constexpr float kMainLight = 0.40F;
constexpr float kSecondLight = 0.22F;
constexpr float kCameraLight = 0.12F;
constexpr float kHaze_perm = 0.025F;

float dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
float positive(float x) { return x > 0.0F ? x : 0.0F; }
float magnitude(float x) { return x < 0.0F ? -x : x; }

/// Number of the band of `size` that a coordinate lies in. Counts from far below, where truncation is floor.
int band(float x_m, float size_m) { return static_cast<int>(x_m / size_m + 4096.0F); }

Shade lit(const Rgb& base, const Vec& normal, const Vec& direction, float t, float inverse_length) {
  float cosine = magnitude(dot(normal, direction)) * inverse_length;
  cosine = cosine > 1.0F ? 1.0F : cosine;
  const float light = (kAmbient + kMainLight * positive(dot(normal, kMainLamp)) +
                       kSecondLight * positive(dot(normal, kSecondLamp)) + kCameraLight * cosine) /
                      (1.0F + kHaze_perm * t);
  const auto channel = [light](std::uint8_t c) {
    const float value = static_cast<float>(c) * light + 0.5F;
    return static_cast<std::uint8_t>(value > 255.0F ? 255.0F : value);
  };
  return {{channel(base.r), channel(base.g), channel(base.b)}, cosine};
}

/// Outward normal in the solid's own axes.
Vec local_normal(const PreparedSolid& s, const Vec& p) {
  const Vec beyond = {magnitude(p[0]) - s.half[0], magnitude(p[1]) - s.half[1], magnitude(p[2]) - s.half[2]};
  if (s.shape == Shape::box) {
    const int axis = beyond[0] > beyond[1] ? (beyond[0] > beyond[2] ? 0 : 2) : (beyond[1] > beyond[2] ? 1 : 2);
    Vec normal{};
    normal[static_cast<std::size_t>(axis)] = p[static_cast<std::size_t>(axis)] < 0.0F ? -1.0F : 1.0F;
    return normal;
  }
  if (s.shape == Shape::sphere) {
    const float inverse = 1.0F / s.radius;
    return {p[0] * inverse, p[1] * inverse, p[2] * inverse};
  }
  // Lid or base if the point is nearer to it than to the mantle.
  const float radial = std::sqrt(p[0] * p[0] + p[1] * p[1]);
  const float mantle = s.radius + s.slope * p[2];
  if (magnitude(beyond[2]) < magnitude(radial - mantle)) return {0.0F, 0.0F, p[2] < 0.0F ? -1.0F : 1.0F};
  const float out = 1.0F / std::sqrt(1.0F + s.slope * s.slope);
  const float inverse = radial > 1e-6F ? out / radial : 0.0F;
  return {p[0] * inverse, p[1] * inverse, -s.slope * out};
}

bool takes_second_colour(const PreparedSolid& s, const Material& material, const Vec& p, const Vec& normal) {
  const float size_m = material.texture_size_m;
  if (material.texture == Texture::stripes) {
    const float along = s.shape != Shape::box ? p[2] : s.half[0] >= s.half[1] ? p[0] + s.half[0] : p[1] + s.half[1];
    return (band(along, size_m) & 1) != 0;
  }
  if (s.shape != Shape::box) {
    return ((band(p[2], size_m) + (p[0] > 0.0F ? 1 : 0) + (p[1] > 0.0F ? 1 : 0)) & 1) != 0;
  }
  int parity = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    // Not across the face itself: there the coordinate sits on a band's edge and would flicker.
    if (normal[k] == 0.0F) parity += band(p[k] + s.half[k], size_m);
  }
  return (parity & 1) != 0;
}

constexpr std::array<Rgb, 8> kWallColours = {{{196, 178, 150},
                                              {168, 184, 170},
                                              {186, 158, 150},
                                              {160, 172, 190},
                                              {204, 196, 172},
                                              {178, 166, 188},
                                              {150, 176, 180},
                                              {200, 170, 128}}};
constexpr float kWallPatch_m = 2.5F;
constexpr float kSkirting_m = 0.12F;

}  // namespace

Shade shade_solid(const PreparedSolid& s, const Material& material, const Vec& direction, float t,
                  float inverse_length) {
  const Vec local_direction = {s.cos_yaw * direction[0] + s.sin_yaw * direction[1],
                               s.cos_yaw * direction[1] - s.sin_yaw * direction[0], direction[2]};
  const Vec p = {s.origin[0] + t * local_direction[0], s.origin[1] + t * local_direction[1],
                 s.origin[2] + t * local_direction[2]};
  const Vec n = local_normal(s, p);
  const bool second = material.texture != Texture::plain && takes_second_colour(s, material, p, n);
  const Vec normal = {s.cos_yaw * n[0] - s.sin_yaw * n[1], s.sin_yaw * n[0] + s.cos_yaw * n[1], n[2]};
  return lit(second ? material.second_colour : material.colour, normal, direction, t, inverse_length);
}

Shade shade_grid(const GridWalls& grid, int axis, const Vec& origin_m, const Vec& direction, float t,
                 float inverse_length) {
  Vec normal{};
  const auto k = static_cast<std::size_t>(axis);
  normal[k] = direction[k] > 0.0F ? -1.0F : 1.0F;
  const int i = band(origin_m[0] + t * direction[0], kWallPatch_m);
  const int j = band(origin_m[1] + t * direction[1], kWallPatch_m);
  const float height_m = origin_m[2] + t * direction[2] - grid.z_low_m();
  Rgb base =
      kWallColours[(static_cast<std::uint32_t>(i) * 2654435761U + static_cast<std::uint32_t>(j) * 2246822519U) >> 29];
  if (height_m < kSkirting_m) base = {92, 72, 58};
  return lit(base, normal, direction, t, inverse_length);
}

Rgb shade_sky(const Vec& direction, float inverse_length) {
  const float up = positive(direction[2] * inverse_length);
  return {static_cast<std::uint8_t>(205.0F - 85.0F * up), static_cast<std::uint8_t>(222.0F - 52.0F * up),
          static_cast<std::uint8_t>(240.0F - 15.0F * up)};
}

Rgb tint(const Rgb& behind, const Rgb& pane) {
  const auto mix = [](int b, int p) { return static_cast<std::uint8_t>((3 * b + p + 2) / 4); };
  return {mix(behind.r, pane.r), mix(behind.g, pane.g), mix(behind.b, pane.b)};
}

}  // namespace g3d::hal
