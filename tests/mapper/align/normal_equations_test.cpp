// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/normal_equations.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <eigen3/Eigen/Cholesky>
#include <random>
#include <vector>

using namespace g3d::mapper::align;

namespace {

using EigenMatrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using EigenVector6 = Eigen::Matrix<double, 6, 1>;

struct Term {
  std::array<float, 6> j;
  float residual;
  float weight;
};

std::vector<Term> random_terms(std::size_t count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> arm(-3.0F, 3.0F);
  std::uniform_real_distribution<float> error(-0.05F, 0.05F);
  std::uniform_real_distribution<float> weight(0.0F, 1.0F);
  std::vector<Term> terms(count);
  for (Term& term : terms) {
    for (float& x : term.j) x = arm(random);
    term.residual = error(random);
    term.weight = weight(random);
  }
  return terms;
}

}  // namespace

TEST_CASE("sums of the normal equations agree with Eigen's products", "[mapper][align]") {
  NormalSums sums;
  EigenMatrix6 a = EigenMatrix6::Zero();
  EigenVector6 b = EigenVector6::Zero();
  double square = 0.0;
  const auto terms = random_terms(3000);
  for (const Term& term : terms) {
    sums.add(term.j, term.residual, term.weight);
    EigenVector6 j;
    for (int i = 0; i < 6; ++i) j[i] = static_cast<double>(term.j[static_cast<std::size_t>(i)]);
    a += static_cast<double>(term.weight) * j * j.transpose();
    b += static_cast<double>(term.weight) * static_cast<double>(term.residual) * j;
    square += static_cast<double>(term.weight * term.residual * term.residual);
  }
  const Matrix6 mine = sums.matrix();
  const Vector6 gradient = sums.gradient_vector();
  for (int i = 0; i < 6; ++i) {
    CHECK(gradient[static_cast<std::size_t>(i)] == Approx(b[i]).margin(0.01));
    for (int k = 0; k < 6; ++k) CHECK(mine[static_cast<std::size_t>(6 * i + k)] == Approx(a(i, k)).margin(0.01));
  }
  CHECK(sums.mean_square() == Approx(square / 3000.0));
  CHECK(sums.matched == 3000);
}

TEST_CASE("the order of the terms does not matter, to the last bit", "[mapper][align]") {
  auto terms = random_terms(2000);
  const auto total = [&] {
    NormalSums sums;
    for (const Term& term : terms) {
      sums.add(term.j, term.residual, term.weight);
      sums.add_cost(term.residual * term.residual);
    }
    return sums;
  };
  const NormalSums forward = total();
  std::shuffle(terms.begin(), terms.end(), std::mt19937(9));
  const NormalSums shuffled = total();
  CHECK(forward.upper == shuffled.upper);
  CHECK(forward.gradient == shuffled.gradient);
  CHECK(forward.square == shuffled.square);
  CHECK(forward.cost == shuffled.cost);
}

TEST_CASE("solve agrees with Eigen and refuses what is not positive definite", "[mapper][align]") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 100; ++round) {
    EigenMatrix6 m;
    EigenVector6 b;
    for (int i = 0; i < 6; ++i) {
      b[i] = normal(random);
      for (int k = 0; k < 6; ++k) m(i, k) = normal(random);
    }
    const EigenMatrix6 a = m * m.transpose() + 0.01 * EigenMatrix6::Identity();
    const EigenVector6 expected = a.llt().solve(b);
    Matrix6 mine{};
    Vector6 right{};
    Vector6 x{};
    for (int i = 0; i < 6; ++i) {
      right[static_cast<std::size_t>(i)] = b[i];
      for (int k = 0; k < 6; ++k) mine[static_cast<std::size_t>(6 * i + k)] = a(i, k);
    }
    REQUIRE(solve(mine, right, x));
    for (int i = 0; i < 6; ++i) CHECK(x[static_cast<std::size_t>(i)] == Approx(expected[i]).epsilon(1e-6));
    CHECK(quadratic(mine, right) == Approx(b.dot(a * b)));
    mine[7 * 3] = -1.0;
    CHECK_FALSE(solve(mine, right, x));
  }
}
