// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/render.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/image/png_writer.hpp"
#include "mapper/files/scene.hpp"

namespace g3d::mapper {
namespace {

using Vector = std::array<double, 3>;

constexpr Rgb kSkyTop{0.93F, 0.95F, 0.98F};
constexpr Rgb kSkyBottom{0.70F, 0.74F, 0.80F};
constexpr Rgb kTrajectory{0.90F, 0.16F, 0.35F};
constexpr double kDegree = 3.14159265358979323846 / 180.0;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Pinhole camera that looks down at a scene from such a distance, and is aimed and zoomed so, that the scene fills the
/// picture. The long lens distorts little: rooms stay rectangular.
class View {
 public:
  View(const Scene& scene, const Grid& grid, const RenderOptions& options, hal::ImageSize size) {
    const double azimuth = options.azimuth_deg * kDegree;
    const double elevation = std::clamp(options.elevation_deg, 1.0, 89.0) * kDegree;
    const Vector back{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                      std::sin(elevation)};
    forward_ = {-back[0], -back[1], -back[2]};
    right_ = {-std::sin(azimuth), std::cos(azimuth), 0};
    down_ = {std::sin(elevation) * std::cos(azimuth), std::sin(elevation) * std::sin(azimuth), -std::cos(elevation)};
    const Vector diagonal = minus(scene.high_m, scene.low_m);
    const double distance_m = 0.5 + 1.6 * std::sqrt(dot(diagonal, diagonal));
    for (std::size_t i = 0; i < 3; ++i) eye_[i] = (scene.low_m[i] + scene.high_m[i]) / 2 + back[i] * distance_m;

    double left = 1e9, top = 1e9, right = -1e9, bottom = -1e9;  // of the scene, on the plane one metre before the eye
    for (std::size_t i = 0; i < scene.voxels.size(); i += 1 + scene.voxels.size() / 100000) {
      const Vector p = grid.centre_m(scene.voxels[i].index);
      if (!scene.holds(p) || !is_before(p)) continue;
      const Vector d = minus(p, eye_);
      const double depth_m = dot(d, forward_);
      left = std::min(left, dot(d, right_) / depth_m);
      right = std::max(right, dot(d, right_) / depth_m);
      top = std::min(top, dot(d, down_) / depth_m);
      bottom = std::max(bottom, dot(d, down_) / depth_m);
    }
    focal_px_ = std::min(0.93 * size.width_px / std::max(right - left, 1e-3),
                         0.92 * size.height_px / std::max(bottom - top, 1e-3));
    centre_x_px_ = size.width_px / 2.0 - focal_px_ * (left + right) / 2;
    centre_y_px_ = size.height_px / 2.0 - focal_px_ * (top + bottom) / 2;
  }
  [[nodiscard]] ScreenPoint project(const Vector& p) const {
    const Vector d = minus(p, eye_);
    const double depth_m = std::max(dot(d, forward_), 0.01);
    return {static_cast<float>(centre_x_px_ + focal_px_ * dot(d, right_) / depth_m),
            static_cast<float>(centre_y_px_ + focal_px_ * dot(d, down_) / depth_m), static_cast<float>(depth_m)};
  }
  [[nodiscard]] bool faces_eye(const Vector& point, const Vector& normal) const {
    return dot(minus(eye_, point), normal) > 0;
  }
  [[nodiscard]] bool is_towards_eye(const Vector& normal) const { return dot(forward_, normal) < 0; }
  [[nodiscard]] bool is_before(const Vector& p) const { return dot(minus(p, eye_), forward_) > 0.05; }

 private:
  Vector eye_{}, forward_{}, right_{}, down_{};
  double focal_px_ = 1, centre_x_px_ = 0, centre_y_px_ = 0;
};

/// Light from above left; undersides are dark; corners, where many neighbours are, a little darker.
float brightness(std::size_t face, std::uint8_t openness) {
  constexpr std::array<float, 6> kLight{0.88F, 0.82F, 0.93F, 0.77F, 1.0F, 0.5F};
  const float free_part = std::clamp((static_cast<float>(openness) - 6.0F) / 12.0F, 0.0F, 1.0F);
  return kLight[face] * (0.78F + 0.22F * free_part);
}

std::array<Vector, 4> face_corners(const Vector& centre, std::size_t face, double half_m) {
  const auto& n = kFaceNormals[face];
  const std::size_t axis = face / 2;
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  std::array<Vector, 4> corners;
  constexpr std::array<std::array<double, 2>, 4> kAround{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    corners[i] = centre;
    corners[i][axis] += n[axis] * half_m;
    corners[i][u] += kAround[i][0] * half_m;
    corners[i][v] += kAround[i][1] * half_m;
  }
  return corners;
}

/// Faces whose outer side the eye sees, in parallel view: one answer for all voxels.
std::uint8_t faces_to_eye(const View& view) {
  unsigned faces = 0;
  for (std::size_t face = 0; face < kFaceNormals.size(); ++face) {
    const auto& n = kFaceNormals[face];
    const bool towards =
        view.is_towards_eye({static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])});
    faces |= (towards ? 1U : 0U) << face;
  }
  return static_cast<std::uint8_t>(faces);
}

/// A voxel is drawn if its surface was seen from any of the eye's sides; then all of its sides are, or pits would be
/// holes.
void draw_voxel(Picture& picture, const View& view, std::uint8_t to_eye, const SceneVoxel& voxel, const Vector& centre,
                double half_m) {
  if ((voxel.seen_from & to_eye) == 0) return;
  for (std::size_t face = 0; face < kFaceNormals.size(); ++face) {
    if ((voxel.bare >> face & 1U) == 0) continue;
    const auto corners = face_corners(centre, face, half_m);
    const auto& n = kFaceNormals[face];
    if (!view.faces_eye(corners[0], {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])}))
      continue;
    const std::array<ScreenPoint, 4> on_screen{view.project(corners[0]), view.project(corners[1]),
                                               view.project(corners[2]), view.project(corners[3])};
    picture.draw_quad(on_screen, voxel.colour * brightness(face, voxel.openness));
  }
}

}  // namespace

std::vector<std::uint8_t> render_perspective(const VoxelMap& map, const RenderOptions& options) {
  const hal::ImageSize twice{2 * options.size.width_px, 2 * options.size.height_px};
  Picture picture(twice, kSkyTop, kSkyBottom);
  const Scene scene = make_scene(map, options.use_colour);
  if (scene.voxels.empty()) return picture.halved();
  const View view(scene, map.grid(), options, twice);
  const double half_m = 0.5 * static_cast<double>(map.grid().resolution_m);
  const std::uint8_t to_eye = faces_to_eye(view);
  for (const SceneVoxel& voxel : scene.voxels) {
    const Vector centre = map.grid().centre_m(voxel.index);
    if (!scene.is_above(centre) && view.is_before(centre)) draw_voxel(picture, view, to_eye, voxel, centre, half_m);
  }
  picture.shade_by_depth(4, 45.0F);
  for (std::size_t i = 1; i < options.trajectory.size(); ++i) {
    const Vector& from = options.trajectory[i - 1].translation_m;
    const Vector& to = options.trajectory[i].translation_m;
    if (view.is_before(from) && view.is_before(to))
      picture.draw_line(view.project(from), view.project(to), 3.5F, kTrajectory);
  }
  return picture.halved();
}

hal::Result<void> write_perspective(const VoxelMap& map, const std::string& path, const RenderOptions& options) {
  return hal::write_png_rgb(path, options.size, render_perspective(map, options));
}

}  // namespace g3d::mapper
