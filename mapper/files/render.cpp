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

/// Pinhole camera that looks at the middle of a box from far enough to see all of it.
class View {
 public:
  View(const Vector& low_m, const Vector& high_m, const RenderOptions& options, hal::ImageSize size) : size_(size) {
    const double azimuth = options.azimuth_deg * kDegree;
    const double elevation = std::clamp(options.elevation_deg, 1.0, 89.0) * kDegree;
    const Vector back{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
    forward_ = {-back[0], -back[1], -back[2]};
    right_ = {-std::sin(azimuth), std::cos(azimuth), 0};
    down_ = {std::sin(elevation) * std::cos(azimuth), std::sin(elevation) * std::sin(azimuth), -std::cos(elevation)};
    focal_px_ = 1.5 * size.width_px;  // a long lens: little distortion, rooms stay rectangular
    const Vector middle{(low_m[0] + high_m[0]) / 2, (low_m[1] + high_m[1]) / 2, (low_m[2] + high_m[2]) / 2};
    double distance_m = 0.5;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector p{(corner & 1) != 0 ? high_m[0] : low_m[0], (corner & 2) != 0 ? high_m[1] : low_m[1], (corner & 4) != 0 ? high_m[2] : low_m[2]};
      const Vector d = minus(p, middle);
      const double half_width = 0.47 * size.width_px / focal_px_;
      const double half_height = 0.46 * size.height_px / focal_px_;
      distance_m = std::max({distance_m, std::abs(dot(d, right_)) / half_width - dot(d, forward_), std::abs(dot(d, down_)) / half_height - dot(d, forward_)});
    }
    eye_ = {middle[0] + back[0] * distance_m, middle[1] + back[1] * distance_m, middle[2] + back[2] * distance_m};
  }
  [[nodiscard]] ScreenPoint project(const Vector& p) const {
    const Vector d = minus(p, eye_);
    const double depth_m = std::max(dot(d, forward_), 0.01);
    return {static_cast<float>(size_.width_px / 2.0 + focal_px_ * dot(d, right_) / depth_m),
            static_cast<float>(size_.height_px / 2.0 + focal_px_ * dot(d, down_) / depth_m), static_cast<float>(depth_m)};
  }
  [[nodiscard]] bool faces_eye(const Vector& point, const Vector& normal) const { return dot(minus(eye_, point), normal) > 0; }
  [[nodiscard]] bool is_before(const Vector& p) const { return dot(minus(p, eye_), forward_) > 0.05; }

 private:
  hal::ImageSize size_;
  Vector eye_{}, forward_{}, right_{}, down_{};
  double focal_px_ = 1;
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

void draw_voxel(Picture& picture, const View& view, const SceneVoxel& voxel, const Vector& centre, double half_m) {
  for (std::size_t face = 0; face < kFaceNormals.size(); ++face) {
    if ((voxel.faces >> face & 1U) == 0) continue;
    const auto corners = face_corners(centre, face, half_m);
    const auto& n = kFaceNormals[face];
    if (!view.faces_eye(corners[0], {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])})) continue;
    const std::array<ScreenPoint, 4> on_screen{view.project(corners[0]), view.project(corners[1]), view.project(corners[2]), view.project(corners[3])};
    picture.draw_quad(on_screen, voxel.colour * brightness(face, voxel.openness));
  }
}

}  // namespace

std::vector<std::uint8_t> render_perspective(const VoxelMap& map, const RenderOptions& options) {
  const hal::ImageSize twice{2 * options.size.width_px, 2 * options.size.height_px};
  Picture picture(twice, kSkyTop, kSkyBottom);
  const Scene scene = make_scene(map, options.use_colour);
  if (scene.voxels.empty()) return picture.halved();
  const View view(scene.low_m, scene.high_m, options, twice);
  const double half_m = 0.5 * static_cast<double>(map.grid().resolution_m);
  for (const SceneVoxel& voxel : scene.voxels) {
    const Vector centre = map.grid().centre_m(voxel.index);
    if (centre[2] <= scene.ceiling_m && view.is_before(centre)) draw_voxel(picture, view, voxel, centre, half_m);
  }
  picture.shade_by_depth(4, 60.0F);
  for (std::size_t i = 1; i < options.trajectory.size(); ++i) {
    const Vector& from = options.trajectory[i - 1].translation_m;
    const Vector& to = options.trajectory[i].translation_m;
    if (view.is_before(from) && view.is_before(to)) picture.draw_line(view.project(from), view.project(to), 3.5F, kTrajectory);
  }
  return picture.halved();
}

hal::Result<void> write_perspective(const VoxelMap& map, const std::string& path, const RenderOptions& options) {
  return hal::write_png_rgb(path, options.size, render_perspective(map, options));
}

}  // namespace g3d::mapper
