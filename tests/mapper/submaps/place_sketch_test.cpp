// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/place_sketch.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "mapper/align/depth_sample.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

/// Walls of different heights around a place, drawn by seed.
std::vector<align::DepthSample> place(std::uint32_t seed) {
  tests::Random random(seed);
  std::vector<align::DepthSample> surfaces;
  for (int wall = 0; wall < 12; ++wall) {
    const double from_rad = 6.283 * wall / 12.0;
    const double away_m = random.uniform(1.0, 5.5);
    const double top_m = random.uniform(-0.4, 1.6);
    for (double a = from_rad; a < from_rad + 0.5; a += 0.02) {
      for (double z_m = -0.5; z_m < top_m; z_m += 0.08) {
        const auto c = static_cast<float>(std::cos(a));
        const auto s = static_cast<float>(std::sin(a));
        surfaces.push_back({{static_cast<float>(away_m) * c, static_cast<float>(away_m) * s, static_cast<float>(z_m)},
                            {-c, -s, 0.0F},
                            1.0F});
      }
    }
  }
  return surfaces;
}

std::vector<align::DepthSample> seen_from(const std::vector<align::DepthSample>& surfaces, const hal::Pose& pose) {
  const hal::RigidTransform T = hal::to_transform(hal::inverse(pose));
  std::vector<align::DepthSample> moved;
  for (align::DepthSample sample : surfaces) {
    sample.point_m = align::transformed(T, sample.point_m);
    sample.normal = align::rotated(T, sample.normal);
    moved.push_back(sample);
  }
  return moved;
}

}  // namespace

TEST_CASE("a place is recognised from another side, and by how much one has turned") {
  const auto surfaces = place(1);
  const PlaceSketch sketch(surfaces, {});
  const PlaceSketch::Likeness same = sketch.likeness(PlaceSketch(surfaces, {}));
  CHECK(same.share == Approx(1.0).margin(1e-5));
  CHECK(same.turn_rad == 0.0);
  for (const double turn_rad : {0.5, 2.0, -1.3}) {
    const PlaceSketch turned(seen_from(surfaces, hal::from_xyz_rpy(0.1, 0.1, 0, 0, 0, turn_rad)), {});
    const PlaceSketch::Likeness likeness = sketch.likeness(turned);
    CHECK(likeness.share > 0.7);
    CHECK(std::remainder(likeness.turn_rad - turn_rad, 6.283185307) == Approx(0.0).margin(0.11));
  }
  double others = 0.0;
  for (std::uint32_t seed = 2; seed < 12; ++seed) {
    others = std::max(others, sketch.likeness(PlaceSketch(place(seed), {})).share);
  }
  CHECK(others < 0.7);
}

TEST_CASE("of what only one of them has seen nothing is said, and of too little neither") {
  const auto surfaces = place(5);
  std::vector<align::DepthSample> half;
  std::vector<align::DepthSample> slice;
  std::vector<align::DepthSample> floor;
  for (align::DepthSample sample : surfaces) {
    if (sample.point_m[1] > 0.0F) half.push_back(sample);
    if (sample.point_m[0] > std::abs(sample.point_m[1])) slice.push_back(sample);
    sample.normal = {0.0F, 0.0F, 1.0F};
    floor.push_back(sample);
  }
  const PlaceSketch sketch(surfaces, {});
  CHECK(sketch.likeness(PlaceSketch(half, {})).share == Approx(1.0).margin(1e-5));
  CHECK(sketch.likeness(PlaceSketch(slice, {})).share > 0.9);
  CHECK(sketch.likeness(PlaceSketch(floor, {})).share == 0.0);
  CHECK(PlaceSketch().likeness(sketch).share == 0.0);
}
