// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/map_aligner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <eigen3/Eigen/Eigenvalues>
#include <numbers>
#include <vector>

#include "mapper/align/point_to_plane.hpp"
#include "mapper/align/pose_step.hpp"
#include "mapper/rgbo.hpp"

namespace g3d::mapper::align {
namespace {

constexpr std::size_t kLeastMapSamples = 200;
constexpr std::size_t kScored = 250;
constexpr std::size_t kRefined = 1500;
constexpr std::size_t kJudged = 6000;
constexpr std::size_t kCandidates = 12;
constexpr std::size_t kCandidatesAnywhere = 60;
constexpr double kTurnStep_rad = 5.0 * std::numbers::pi / 180.0;
constexpr double kShiftStep_m = 0.25;
constexpr double kMostPlaces = 1e6;
constexpr float kCoarseKernel_m = 0.15F;
constexpr float kFineKernel_m = 0.04F;
constexpr int kCoarseSteps = 12;
constexpr int kFineSteps = 15;
// Robots stand on the same kind of floor: of these sizes may the height differ and the tilt.
constexpr double kHeightSigma_m = 0.1;
constexpr double kTiltSigma_rad = 0.03;
// Answers nearer to each other than this are one.
constexpr float kLevelCosine = 0.7F;
constexpr double kSamePlace_m = 0.3;
constexpr double kSameTurn_rad = 0.15;
constexpr double kRivals = 0.93;
// The weakest direction must have this share of the surface facing along it.
constexpr double kLeastHold = 0.02;

constexpr std::array<const char*, 6> kMapOutcomeNames{"aligned",      "too_little", "little_overlap",
                                                      "contradicted", "unfixed",    "ambiguous"};

/// What stands: floors and ceilings fit everywhere and say nothing about the place.
std::vector<DepthSample> upright(const std::vector<DepthSample>& samples) {
  std::vector<DepthSample> result;
  for (const DepthSample& sample : samples) {
    if (std::abs(sample.normal[2]) < kLevelCosine) result.push_back(sample);
  }
  return result;
}

struct Candidate {
  hal::Pose pose;
  double score = 0.0;
};

/// T_a_b that turns b by yaw about the vertical through a point of it, and shifts it, after `guess`.
hal::Pose displaced(const hal::Pose& guess, const Vector3f& pivot_m, double x_m, double y_m, double yaw_rad) {
  const std::array<double, 3> m{static_cast<double>(pivot_m[0]), static_cast<double>(pivot_m[1]),
                                static_cast<double>(pivot_m[2])};
  const hal::Pose to_middle{{m[0], m[1], m[2]}, {0, 0, 0, 1}};
  const hal::Pose middle_in_a = hal::compose(guess, to_middle);
  hal::Pose turned = hal::compose(hal::from_xyz_rpy(0, 0, 0, 0, 0, yaw_rad), {{0, 0, 0}, middle_in_a.rotation_xyzw});
  turned.translation_m = {middle_in_a.translation_m[0] + x_m, middle_in_a.translation_m[1] + y_m,
                          middle_in_a.translation_m[2]};
  return hal::compose(turned, hal::inverse(to_middle));
}

double score_of(const std::vector<DepthSample>& samples, const SurfaceMap& surfaces, const hal::Pose& pose) {
  const NormalSums sums = match(samples, surfaces, pose, kCoarseKernel_m);
  if (sums.matched == 0) return 0.0;
  // Matched surface, less what it costs: a share of 1 fits exactly.
  const double ceiling = static_cast<double>(kCoarseKernel_m) * static_cast<double>(kCoarseKernel_m);
  return static_cast<double>(sums.matched) * (1.0 - sums.mean_cost() / ceiling) / static_cast<double>(samples.size());
}

/// The best places, one of each neighbourhood.
std::vector<Candidate> search(const MapSurfaces& a, const MapSurfaces& b, const hal::Pose& guess,
                              const MapAlignOptions& options, std::uint64_t& tried) {
  const std::vector<DepthSample> samples = evenly(upright(b.samples()), 0.3F, kScored);
  std::vector<Candidate> all;
  double low_x = -options.reach_m;
  double high_x = options.reach_m;
  double low_y = -options.reach_m;
  double high_y = options.reach_m;
  double reach_rad = options.reach_rad;
  if (options.anywhere) {
    const hal::Pose middle =
        hal::compose(guess, {{static_cast<double>(b.centre_m()[0]), static_cast<double>(b.centre_m()[1]),
                              static_cast<double>(b.centre_m()[2])},
                             {0, 0, 0, 1}});
    low_x = static_cast<double>(a.low_m()[0]) - middle.translation_m[0];
    high_x = static_cast<double>(a.high_m()[0]) - middle.translation_m[0];
    low_y = static_cast<double>(a.low_m()[1]) - middle.translation_m[1];
    high_y = static_cast<double>(a.high_m()[1]) - middle.translation_m[1];
    reach_rad = std::numbers::pi - 0.5 * kTurnStep_rad;
  }
  // In a map so large that the places were too many, they stand farther apart, and fewer answers are sure enough.
  const double places_per_step2 = (high_x - low_x) * (high_y - low_y) * 2.0 * reach_rad / kTurnStep_rad;
  const double step_m = std::max(kShiftStep_m, std::sqrt(places_per_step2 / kMostPlaces));
  // A robot errs about where it started, which is where its map has its origin.
  const Vector3f pivot_m = options.anywhere ? b.centre_m() : Vector3f{};
  const int turns = static_cast<int>(std::ceil(reach_rad / kTurnStep_rad));
  for (int turn = -turns; turn <= turns; ++turn) {
    for (double x_m = low_x; x_m <= high_x + 1e-9; x_m += step_m) {
      for (double y_m = low_y; y_m <= high_y + 1e-9; y_m += step_m) {
        Candidate c{displaced(guess, pivot_m, x_m, y_m, turn * kTurnStep_rad), 0.0};
        c.score = score_of(samples, a.coarse(), c.pose);
        all.push_back(c);
      }
    }
  }
  all.push_back({guess, score_of(samples, a.coarse(), guess) + (options.anywhere ? 0.0 : 1.0)});  // always refined
  tried = all.size();
  std::stable_sort(all.begin(), all.end(), [](const Candidate& x, const Candidate& y) { return x.score > y.score; });
  std::vector<Candidate> best;
  for (const Candidate& c : all) {
    const bool is_new = std::none_of(best.begin(), best.end(), [&](const Candidate& other) {
      const Vector6 off = difference(other.pose, c.pose);
      return turn_of(off) < kSameTurn_rad && shift_of(off) < kSamePlace_m;
    });
    if (is_new) best.push_back(c);
    if (best.size() == (options.anywhere ? kCandidatesAnywhere : kCandidates)) break;
  }
  return best;
}

hal::Pose refined(const std::vector<DepthSample>& samples, const SurfaceMap& surfaces, const hal::Pose& start,
                  const hal::Pose& guess, float kernel_m, int steps) {
  hal::Pose pose = start;
  for (int i = 0; i < steps; ++i) {
    const NormalSums sums = match(samples, surfaces, pose, kernel_m);
    if (sums.matched < 50) return pose;
    Matrix6 m = sums.matrix();
    Vector6 g = sums.gradient_vector();
    const Vector6 off = difference(pose, guess);
    const double unit = 1.0 / (static_cast<double>(kernel_m) * static_cast<double>(kernel_m));
    for (double& v : m) v *= unit;
    for (std::size_t k = 0; k < 6; ++k) g[k] *= -unit;
    const auto hold = [&](std::size_t k, double sigma) {
      m[7 * k] += 1.0 / (sigma * sigma);
      g[k] += off[k] / (sigma * sigma);
    };
    hold(2, kHeightSigma_m);
    hold(3, kTiltSigma_rad);
    hold(4, kTiltSigma_rad);
    for (std::size_t k : {std::size_t{0}, std::size_t{1}, std::size_t{5}}) m[7 * k] += 1e-6 * m[7 * k] + 1e-9;
    Vector6 x{};
    if (!solve(m, g, x)) return pose;
    const double longest = 0.5 * static_cast<double>(surfaces.options().rule.cell_m) + 0.05;
    const double shrink = std::min({1.0, longest / std::max(shift_of(x), 1e-12), 0.1 / std::max(turn_of(x), 1e-12)});
    for (double& v : x) v *= shrink;
    pose = moved(pose, x);
    if (shift_of(x) < 1e-4 && turn_of(x) < 5e-5) break;
  }
  return pose;
}

struct Agreement {
  double matched = 0.0;
  double contradicted = 0.0;
  [[nodiscard]] double share() const { return matched + contradicted > 0.0 ? matched / (matched + contradicted) : 0.0; }
};

/// How much of `samples` agrees with a map: surface on surface, or surface in what the map has seen to be free.
Agreement agreement(const std::vector<DepthSample>& samples, const MapSurfaces& with, const hal::Pose& T_with_samples) {
  Agreement result;
  const hal::RigidTransform T = hal::to_transform(T_with_samples);
  for (const DepthSample& sample : samples) {
    const Vector3f at = transformed(T, sample.point_m);
    const auto piece = with.fine().find(at, rotated(T, sample.normal));
    if (piece && std::abs(dot(piece->normal, {at[0] - piece->point_m[0], at[1] - piece->point_m[1],
                                              at[2] - piece->point_m[2]})) <= with.tolerance_m()) {
      result.matched += 1.0;
      continue;
    }
    // Free at the surface and behind it: a wall cannot be there.
    const Vector3f n = rotated(T, sample.normal);
    const float depth_m = 2.0F * with.map().grid().resolution_m;
    const auto state = [&](float behind_m) {
      return state_of(with.map().at(
          with.map().grid().to_index(at[0] - behind_m * n[0], at[1] - behind_m * n[1], at[2] - behind_m * n[2])));
    };
    if (state(0.0F) == State::free && state(depth_m) == State::free) result.contradicted += 1.0;
  }
  return result;
}

double hold_of(const std::vector<DepthSample>& samples, const SurfaceMap& surfaces, const hal::Pose& pose) {
  const Matrix6 m = match(samples, surfaces, pose, kFineKernel_m).matrix();
  Eigen::Matrix2d floor;
  floor << m[0], m[1], m[6], m[7];
  const auto values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(floor, Eigen::EigenvaluesOnly).eigenvalues();
  return m[0] + m[7] > 0.0 ? values[0] / (m[0] + m[7]) : 0.0;
}

}  // namespace

const char* to_string(MapAlignOutcome outcome) { return kMapOutcomeNames[static_cast<std::size_t>(outcome)]; }

MapAlignment align_maps(const MapSurfaces& a, const MapSurfaces& b, const hal::Pose& guess,
                        const MapAlignOptions& options) {
  MapAlignment result;
  result.T_a_b = guess;
  if (a.samples().size() < kLeastMapSamples || b.samples().size() < kLeastMapSamples) return result;
  const std::vector<DepthSample> few = evenly(b.samples(), 0.2F, kRefined);
  const std::vector<DepthSample> standing_a = upright(a.samples());
  const std::vector<DepthSample> standing_b = upright(b.samples());
  const std::vector<DepthSample> many_b = evenly(standing_b, 0.1F, kJudged);
  const std::vector<DepthSample> many_a = evenly(standing_a, 0.1F, kJudged);
  if (many_a.size() < kLeastMapSamples || many_b.size() < kLeastMapSamples) return result;
  const double area_m2 = static_cast<double>(b.fine().options().rule.cell_m * b.fine().options().rule.cell_m) *
                         static_cast<double>(standing_b.size()) / static_cast<double>(many_b.size());

  struct Answer {
    hal::Pose pose;
    double overlap = 0.0;
    double area_m2 = 0.0;
  };
  std::vector<Answer> answers;
  for (const Candidate& candidate : search(a, b, guess, options, result.tried)) {
    const hal::Pose rough = refined(few, a.coarse(), candidate.pose, candidate.pose, kCoarseKernel_m, kCoarseSteps);
    const hal::Pose pose = refined(few, a.fine(), rough, candidate.pose, kFineKernel_m, kFineSteps);
    const Agreement there = agreement(many_b, a, pose);
    const Agreement back = agreement(many_a, b, hal::inverse(pose));
    answers.push_back({pose, std::min(there.share(), back.share()), there.matched * area_m2});
  }
  const auto worth = [&](const Answer& x) { return x.overlap * std::min(1.0, x.area_m2 / options.least_area_m2); };
  std::stable_sort(answers.begin(), answers.end(),
                   [&](const Answer& x, const Answer& y) { return worth(x) * x.area_m2 > worth(y) * y.area_m2; });
  const Answer& best = answers.front();
  result.T_a_b = best.pose;
  result.overlap = best.overlap;
  result.area_m2 = best.area_m2;
  result.hold = hold_of(few, a.fine(), best.pose);
  result.residual_m = std::sqrt(match(many_b, a.fine(), best.pose, kFineKernel_m).mean_cost());
  for (const Answer& other : answers) {
    const Vector6 off = difference(best.pose, other.pose);
    if (turn_of(off) < kSameTurn_rad && shift_of(off) < kSamePlace_m) continue;
    result.runner_up = std::max(result.runner_up, worth(other) * std::min(1.0, other.area_m2 / best.area_m2));
  }
  result.outcome = best.area_m2 < options.least_area_m2        ? MapAlignOutcome::little_overlap
                   : best.overlap < options.least_overlap      ? MapAlignOutcome::contradicted
                   : result.hold < kLeastHold                  ? MapAlignOutcome::unfixed
                   : result.runner_up > kRivals * best.overlap ? MapAlignOutcome::ambiguous
                                                               : MapAlignOutcome::aligned;
  return result;
}

}  // namespace g3d::mapper::align
