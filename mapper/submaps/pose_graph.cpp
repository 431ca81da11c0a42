// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/pose_graph.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <eigen3/Eigen/Geometry>
#include <eigen3/Eigen/SparseCholesky>

#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::submaps {
namespace {

using align::Vector6;
using Matrix3 = Eigen::Matrix3d;
using Block = Eigen::Matrix<double, 6, 6>;
using Residual = Eigen::Matrix<double, 6, 1>;

// Levenberg's damping, relative to the diagonal: none at first, then more until a step is an improvement.
constexpr double kFirstDamping = 1e-6;
constexpr double kMostDamping = 1e6;
constexpr double kConverged_m = 1e-6;
constexpr double kLessBelief = 0.25;  // from one degree of belief in loops to the next

Matrix3 rotation_of(const hal::Pose& pose) {
  const auto& q = pose.rotation_xyzw;
  return Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
}

Eigen::Vector3d place_of(const hal::Pose& pose) {
  return {pose.translation_m[0], pose.translation_m[1], pose.translation_m[2]};
}

Matrix3 cross(const Eigen::Vector3d& v) {
  Matrix3 m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

/// From where `to` was measured to where it stands, in the frame where it was measured.
Residual residual_of(const GraphEdge& edge, const hal::Pose& from, const hal::Pose& to) {
  const hal::Pose off = hal::compose(hal::inverse(edge.T_from_to), hal::compose(hal::inverse(from), to));
  const Vector6 x = align::difference({}, off);
  Residual r;
  for (int i = 0; i < 6; ++i) r[i] = x[static_cast<std::size_t>(i)];
  return r;
}

Block block_of_information(const align::Matrix6& m) {
  Block b;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) b(i, j) = m[static_cast<std::size_t>(6 * i + j)];
  }
  return b;
}

/// Derivatives of the residual by a small shift and turn of either node along the world's axes (see pose_step.hpp).
void linearise(const GraphEdge& edge, const hal::Pose& from, const hal::Pose& to, Block& by_from, Block& by_to) {
  const Matrix3 into_measured = rotation_of(edge.T_from_to).transpose() * rotation_of(from).transpose();
  by_to.setZero();
  by_to.topLeftCorner<3, 3>() = into_measured;
  by_to.bottomRightCorner<3, 3>() = into_measured;
  by_from = -by_to;
  by_from.topRightCorner<3, 3>() = into_measured * cross(place_of(to) - place_of(from));
}

}  // namespace

align::Matrix6 information_of(const EdgeSigma& sigma) {
  const std::array<double, 6> each{sigma.floor_m,  sigma.floor_m,  sigma.height_m,
                                   sigma.tilt_rad, sigma.tilt_rad, sigma.heading_rad};
  align::Matrix6 m{};
  for (std::size_t i = 0; i < 6; ++i) m[7 * i] = 1.0 / (each[i] * each[i]);
  return m;
}

// A turn about `to` shifts what is fixed to it.
align::Matrix6 information_at(const align::Matrix6& information, const hal::Pose& T_to_new) {
  Block back = Block::Zero();
  const Matrix3 turn = rotation_of(T_to_new);
  back.topLeftCorner<3, 3>() = turn;
  back.bottomRightCorner<3, 3>() = turn;
  back.topRightCorner<3, 3>() = cross(place_of(T_to_new)) * turn;
  const Block moved = back.transpose() * block_of_information(information) * back;
  align::Matrix6 m{};
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) m[static_cast<std::size_t>(6 * i + j)] = moved(i, j);
  }
  return m;
}

void PoseGraph::join(std::uint32_t node, const hal::Pose& T_next_node) {
  std::erase_if(edges_, [&](GraphEdge& edge) {
    if (edge.to == node + 1) edge.information = information_at(edge.information, T_next_node);
    return !join_ends(edge, node, T_next_node);
  });
  nodes_.erase(nodes_.begin() + node + 1);
}

std::uint32_t PoseGraph::add_node(const hal::Pose& T_world_node) {
  nodes_.push_back(T_world_node);
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

void PoseGraph::add_edge(const GraphEdge& edge) {
  assert(edge.from < nodes_.size() && edge.to < nodes_.size() && edge.from != edge.to);
  edges_.push_back(edge);
}

double PoseGraph::square_of(const GraphEdge& edge) const {
  const Residual r = residual_of(edge, nodes_[edge.from], nodes_[edge.to]);
  return r.dot(block_of_information(edge.information) * r);
}

// Agarwal 2013, equation 15: min(1, 2 phi / (phi + chi^2)).
double PoseGraph::scale_of(const GraphEdge& edge, double phi) const {
  return edge.is_loop ? std::min(1.0, 2.0 * phi / (phi + square_of(edge))) : 1.0;
}

// With the scaling's own price, phi (1 - s)^2, so that the sum falls whenever a step is right.
double PoseGraph::cost(double phi) const {
  double sum = 0.0;
  for (const GraphEdge& edge : edges_) {
    const double s = scale_of(edge, phi);
    sum += s * s * square_of(edge) + phi * (1.0 - s) * (1.0 - s);
  }
  return sum;
}

GraphReport PoseGraph::optimise(const GraphOptions& options) {
  GraphReport report;
  report.cost_before = report.cost_after = cost(options.loop_phi);
  if (nodes_.size() < 2 || edges_.empty()) return report;
  double phi = options.loop_phi;
  for (const GraphEdge& edge : edges_) phi = std::max(phi, edge.is_loop ? square_of(edge) : 0.0);
  for (;; phi = std::max(options.loop_phi, phi * kLessBelief)) {
    report.solved = settle(phi, options, report.steps) && report.solved;
    if (phi <= options.loop_phi) break;
  }
  report.cost_after = cost(options.loop_phi);
  return report;
}

bool PoseGraph::settle(double phi, const GraphOptions& options, int& steps) {
  const auto unknowns = static_cast<Eigen::Index>(6 * (nodes_.size() - 1));
  double damping = kFirstDamping;
  double best = cost(phi);
  std::vector<Eigen::Triplet<double>> terms;
  for (int step = 0; step < options.most_steps; ++step) {
    terms.clear();
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unknowns);
    const auto add_block = [&](std::uint32_t row, std::uint32_t column, const Block& block) {
      if (row == 0 || column == 0) return;  // the first node stays
      for (int i = 0; i < 6; ++i) {
        for (int j = 0; j < 6; ++j) {
          terms.emplace_back(static_cast<int>(6 * (row - 1)) + i, static_cast<int>(6 * (column - 1)) + j, block(i, j));
        }
      }
    };
    for (const GraphEdge& edge : edges_) {
      Block by_from;
      Block by_to;
      linearise(edge, nodes_[edge.from], nodes_[edge.to], by_from, by_to);
      const double s = scale_of(edge, phi);
      const Block weight = s * s * block_of_information(edge.information);
      const Residual r = residual_of(edge, nodes_[edge.from], nodes_[edge.to]);
      add_block(edge.from, edge.from, by_from.transpose() * weight * by_from);
      add_block(edge.from, edge.to, by_from.transpose() * weight * by_to);
      add_block(edge.to, edge.from, by_to.transpose() * weight * by_from);
      add_block(edge.to, edge.to, by_to.transpose() * weight * by_to);
      if (edge.from != 0) gradient.segment<6>(6 * (edge.from - 1)) += by_from.transpose() * weight * r;
      if (edge.to != 0) gradient.segment<6>(6 * (edge.to - 1)) += by_to.transpose() * weight * r;
    }
    // A node that no edge reaches stays where it is.
    for (Eigen::Index i = 0; i < unknowns; ++i) terms.emplace_back(static_cast<int>(i), static_cast<int>(i), 1e-9);
    Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
    matrix.setFromTriplets(terms.begin(), terms.end());
    const Eigen::VectorXd diagonal = matrix.diagonal();
    const std::vector<hal::Pose> before = nodes_;
    bool improved = false;
    bool is_solvable = false;
    double longest_m = 0.0;
    for (; !improved && damping <= kMostDamping; damping *= 10.0) {
      Eigen::SparseMatrix<double> damped = matrix;
      for (Eigen::Index i = 0; i < unknowns; ++i) damped.coeffRef(i, i) += damping * diagonal[i];
      const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(damped);
      if (factor.info() != Eigen::Success) continue;
      const Eigen::VectorXd x = -factor.solve(gradient);
      if (!x.allFinite()) continue;
      is_solvable = true;
      longest_m = 0.0;
      for (std::size_t n = 1; n < nodes_.size(); ++n) {
        Vector6 own;
        for (std::size_t i = 0; i < 6; ++i) own[i] = x[static_cast<Eigen::Index>(6 * (n - 1) + i)];
        nodes_[n] = align::moved(before[n], own);
        longest_m = std::max(longest_m, align::shift_of(own));
      }
      const double next = cost(phi);
      improved = next <= best;
      if (improved) best = next;
      if (!improved) nodes_ = before;
    }
    ++steps;
    if (!improved) return is_solvable;  // as good as it gets, to the last digits
    damping = std::max(kFirstDamping, damping / 100.0);
    if (longest_m < kConverged_m) return true;
  }
  return true;
}

}  // namespace g3d::mapper::submaps
