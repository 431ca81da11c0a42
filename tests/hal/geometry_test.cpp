// SPDX-License-Identifier: Apache-2.0
// The written-out arithmetic against Eigen, an implementation by others.
#include "hal/geometry.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <eigen3/Eigen/Geometry>
#include <limits>
#include <random>

using namespace g3d::hal;

namespace {

Eigen::Isometry3d to_eigen(const Pose& p) {
  const auto& q = p.rotation_xyzw;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix();
  T.translation() = Eigen::Vector3d(p.translation_m[0], p.translation_m[1], p.translation_m[2]);
  return T;
}

Pose random_pose(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  Pose p;
  for (double& t : p.translation_m) t = 10 * normal(rng);
  for (double& c : p.rotation_xyzw) c = normal(rng);
  return normalised(p);
}

bool near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double tolerance = 1e-12) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff() < tolerance;
}

}  // namespace

TEST_CASE("compose and inverse agree with Eigen") {
  std::mt19937 rng(1);
  for (int i = 0; i < 500; ++i) {
    const Pose a = random_pose(rng);
    const Pose b = random_pose(rng);
    CHECK(near(to_eigen(compose(a, b)), to_eigen(a) * to_eigen(b), 1e-11));
    CHECK(near(to_eigen(inverse(a)), to_eigen(a).inverse(), 1e-11));
    CHECK(near(to_eigen(compose(a, inverse(a))), Eigen::Isometry3d::Identity(), 1e-11));
  }
}

TEST_CASE("to_transform is the rotation matrix, row by row") {
  std::mt19937 rng(2);
  const Pose p = random_pose(rng);
  const RigidTransform t = to_transform(p);
  const Eigen::Isometry3d T = to_eigen(p);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) CHECK(t.rotation[static_cast<std::size_t>(3 * r + c)] == Approx(T.linear()(r, c)));
    CHECK(t.translation_m[static_cast<std::size_t>(r)] == Approx(T.translation()(r)));
  }
}

TEST_CASE("interpolate is slerp along the shorter arc") {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 500; ++i) {
    const Pose a = random_pose(rng);
    const Pose b = random_pose(rng);
    const double f = uniform(rng);
    const auto& p = a.rotation_xyzw;
    const auto& q = b.rotation_xyzw;
    const Eigen::Quaterniond expected =
        Eigen::Quaterniond(p[3], p[0], p[1], p[2]).slerp(f, Eigen::Quaterniond(q[3], q[0], q[1], q[2]));
    const Pose got = interpolate(a, b, f);
    CHECK((to_eigen(got).linear() - expected.toRotationMatrix()).cwiseAbs().maxCoeff() < 1e-11);
    CHECK(got.translation_m[1] == Approx(a.translation_m[1] * (1 - f) + b.translation_m[1] * f).margin(1e-12));
  }
  const Pose a = random_pose(rng);
  const Pose b = random_pose(rng);
  CHECK(near(to_eigen(interpolate(a, b, 0)), to_eigen(a)));
  CHECK(near(to_eigen(interpolate(a, b, 1)), to_eigen(b)));
  CHECK(near(to_eigen(interpolate(a, a, 0.3)), to_eigen(a)));
}

TEST_CASE("is_valid takes rounded digits and refuses the rest") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(is_valid(Pose{}));
  CHECK(is_valid({{1, 2, 3}, {0.5073524, 0.6470068, -0.5587001, 0.1087650}}));
  CHECK(is_valid({{0, 0, 0}, {0, 0, 0, 0.995}}));
  CHECK_FALSE(is_valid({{0, 0, 0}, {0, 0, 0, 0.98}}));
  CHECK_FALSE(is_valid({{0, 0, 0}, {0, 0, 0, 1.02}}));
  CHECK_FALSE(is_valid({{0, 0, 0}, {0, 0, 0, 0}}));
  CHECK_FALSE(is_valid({{0, nan, 0}, {0, 0, 0, 1}}));
  CHECK_FALSE(is_valid({{0, 0, infinity}, {0, 0, 0, 1}}));
  CHECK_FALSE(is_valid({{0, 0, 0}, {nan, 0, 0, 1}}));
  CHECK_FALSE(is_valid({{0, 0, 0}, {infinity, 0, 0, 1}}));
}

TEST_CASE("from_xyz_rpy turns about x, then y, then z of the parent") {
  const Pose p = from_xyz_rpy(1, 2, 3, 0.1, -0.2, 2.5);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(2.5, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() = Eigen::Vector3d(1, 2, 3);
  CHECK(near(to_eigen(p), T));
}

TEST_CASE("look_at points the optical axis and keeps the horizon level") {
  std::mt19937 rng(4);
  for (int i = 0; i < 200; ++i) {
    const auto eye = random_pose(rng).translation_m;
    const auto target = random_pose(rng).translation_m;
    const Eigen::Isometry3d T = to_eigen(look_at(eye, target));
    const Eigen::Vector3d axis =
        (Eigen::Vector3d(target[0], target[1], target[2]) - Eigen::Vector3d(eye[0], eye[1], eye[2])).normalized();
    CHECK((T.linear().col(2) - axis).norm() < 1e-12);
    CHECK(std::abs(T.linear()(2, 0)) < 1e-12);  // image x is horizontal
    CHECK(T.linear()(2, 1) < 0);                // image y points down
    CHECK(T.linear().determinant() == Approx(1));
  }
  // Forward: image x is to the right (world -y), image y down (world -z).
  const Eigen::Matrix3d forward = to_eigen(look_at({0, 0, 0}, {1, 0, 0})).linear();
  CHECK((forward.col(0) - Eigen::Vector3d(0, -1, 0)).norm() < 1e-12);
  CHECK((forward.col(1) - Eigen::Vector3d(0, 0, -1)).norm() < 1e-12);
  const Eigen::Matrix3d down = to_eigen(look_at({1, 1, 1}, {1, 1, 0})).linear();
  CHECK((down.col(2) - Eigen::Vector3d(0, 0, -1)).norm() < 1e-12);
  CHECK(is_valid(look_at({1, 2, 3}, {1, 2, 3})));
}
