// SPDX-License-Identifier: Apache-2.0
// How much may still be computed in this step, counted in units of work and not in time, so that results repeat on any
// machine. Long computations ask before every piece and go on with the next step when it is spent; a piece that was
// begun is finished, so that even a budget of one unit gets on.
#pragma once

#include <cstdint>
#include <limits>

namespace g3d::nav {

class WorkBudget {
 public:
  /// A unit is worth about a tenth of a microsecond of one core of a server.
  explicit WorkBudget(std::int64_t units) : left_units_(units) {}
  [[nodiscard]] static WorkBudget unlimited() { return WorkBudget(std::numeric_limits<std::int64_t>::max()); }

  void spend(std::int64_t units) { left_units_ -= units; }
  [[nodiscard]] bool is_spent() const { return left_units_ <= 0; }

 private:
  std::int64_t left_units_;
};

}  // namespace g3d::nav
