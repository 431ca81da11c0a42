// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/kinect_noise.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal {
namespace {

constexpr float kStepsPerPixel = 8.0F;
constexpr float kNothingLit = 1e30F;

/// Finaliser of SplitMix64 (Steele, Lea and Flood 2014): every input bit moves every output bit.
std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}
constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15ULL;

/// Nearly Gaussian, mean 0, sigma 1: the sum of three uniform 16-bit numbers (Irwin-Hall); never beyond 3.
float gaussian(std::uint64_t bits) {
  const auto sum = static_cast<std::int32_t>((bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) + ((bits >> 32) & 0xFFFF));
  constexpr float kToSigma = 2.0F / 65536.0F;  // each has variance 2^32 / 12, three of them 2^32 / 4
  return static_cast<float>(sum - 98302) * kToSigma;
}

/// A probability as a threshold for 16 random bits.
std::uint32_t threshold(float probability) { return static_cast<std::uint32_t>(probability * 65536.0F); }

std::uint16_t to_raw(float depth_m, float units_per_metre) {
  const float raw = depth_m * units_per_metre + 0.5F;
  return raw < 65536.0F ? static_cast<std::uint16_t>(raw) : std::uint16_t{0};
}

}  // namespace

KinectNoise::KinectNoise(const CameraModel& camera, std::uint64_t seed, const KinectNoiseModel& model)
    : camera_(camera),
      model_(model),
      seed_(seed),
      edge_share_(std::min(camera.fx_px / model.edge_focal_px, 1.0F)),
      raw_of_step_(kDisparitySteps) {
  const float nearest_step = model.disparity_focal_px * model.baseline_m * kStepsPerPixel;
  for (std::size_t step = 1; step < kDisparitySteps; ++step) {
    raw_of_step_[step] = to_raw(nearest_step / static_cast<float>(step), camera.depth_units_per_metre);
  }
}

void KinectNoise::apply(const ExactView& exact, std::uint64_t frame_number, RowWorkers& workers,
                        std::uint16_t* depth) const {
  const std::uint64_t frame_key = mix(mix(seed_ + kGolden) + kGolden * frame_number);
  workers.run(camera_.height_px, [&](int row) { apply_row(exact, frame_key, static_cast<std::size_t>(row), depth); });
}

bool KinectNoise::is_dropped(float z_m, std::uint8_t surface, std::uint32_t chance) const {
  if (z_m < model_.near_m || z_m > model_.far_m) return true;  // 0, nothing hit, is too near as well
  if ((surface & ExactView::kDark) != 0) return true;
  if (chance < threshold(model_.speckle_dropout)) return true;
  const float cosine = static_cast<float>(surface & ExactView::kCosineMask) / 127.0F;
  if (cosine >= model_.grazing_all_cos) return false;
  const float seen = (cosine - model_.grazing_none_cos) / (model_.grazing_all_cos - model_.grazing_none_cos);
  return chance >= threshold(std::max(seen, 0.0F));
}

void KinectNoise::apply_row(const ExactView& exact, std::uint64_t frame_key, std::size_t row,
                            std::uint16_t* depth) const {
  const auto width = static_cast<std::size_t>(camera_.width_px);
  const auto height = static_cast<std::size_t>(camera_.height_px);
  const float* z_m = &exact.depth_m[row * width];
  const float* above_m = row > 0 ? z_m - width : z_m;
  const float* below_m = row + 1 < height ? z_m + width : z_m;
  const float baseline_px_m = camera_.fx_px * model_.baseline_m;
  const float step_m = model_.disparity_focal_px * model_.baseline_m * kStepsPerPixel;

  // From right to left: in the projector's image the columns must fall too; one that does not is hidden from it.
  float leftmost_lit_px = kNothingLit;
  for (std::size_t u = width; u-- > 0;) {
    const std::size_t pixel = row * width + u;
    depth[pixel] = 0;
    float z = z_m[u];
    if (z <= 0.0F) continue;
    const float projected_px = static_cast<float>(u) - baseline_px_m / z;
    const bool shadowed = projected_px >= leftmost_lit_px;
    leftmost_lit_px = std::min(leftmost_lit_px, projected_px);
    if (shadowed) continue;

    const std::uint64_t bits = mix(frame_key + kGolden * (pixel + 1));
    const auto chance = static_cast<std::uint32_t>(bits >> 48);
    if (is_dropped(z, exact.surface[pixel], chance)) continue;

    const float left = z_m[u > 0 ? u - 1 : u];
    const float right = z_m[u + 1 < width ? u + 1 : u];
    const float high = std::max(std::max(left, right), std::max(above_m[u], below_m[u]));
    const float low = std::min(std::min(left, right), std::min(above_m[u], below_m[u]));
    if (high - low > model_.edge_fraction * z || low <= 0.0F) {
      const std::uint64_t edge_bits = mix(bits);
      if ((edge_bits & 0xFFFF) < threshold(edge_share_ * model_.edge_dropout)) continue;
      // The outline wanders by a pixel of the sensor: its correlation window straddles it.
      const float beside = (edge_bits & 0x10000) != 0 ? left : right;
      // The two bits that have always decided it come first, so that images of the sensor's own size stay as they are.
      const std::uint64_t turned_bits = ((edge_bits >> 17) & 3) << 14 | ((edge_bits >> 19) & 0x3FFF);
      const bool wanders = turned_bits < threshold(edge_share_ * model_.edge_wander);
      if (wanders && beside >= model_.near_m && beside <= model_.far_m) z = beside;
    }
    const float from_m = z - model_.sigma_from_m;
    z += gaussian(bits) * (model_.sigma_0_m + model_.sigma_2_perm * from_m * from_m);
    const auto step = static_cast<std::size_t>(std::floor(step_m / std::max(z, 0.1F) + 0.5F));
    depth[pixel] = raw_of_step_[std::min(step, kDisparitySteps - 1)];
  }
}

void write_exact_depth(const ExactView& exact, const CameraModel& camera, std::uint16_t* depth) {
  for (std::size_t i = 0; i < camera.pixel_count(); ++i) {
    depth[i] = to_raw(exact.depth_m[i], camera.depth_units_per_metre);
  }
}

}  // namespace g3d::hal
