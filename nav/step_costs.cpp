// SPDX-License-Identifier: Apache-2.0
#include "nav/step_costs.hpp"

namespace g3d::nav {
namespace {

constexpr std::uint32_t kReliefCost = 600;  // straight; more than any way round within the relief distance is worth

std::uint16_t as_diagonal(std::uint32_t straight) {
  return static_cast<std::uint16_t>((straight * 99 + 35) / 70);  // 99 / 70 = 1.41429
}
static_assert((kStraightCost * 99 + 35) / 70 == kDiagonalCost);
static_assert((kReliefCost * 99 + 35) / 70 <= kMaxStepCost);

void set(StepCosts& costs, std::size_t cost, std::uint32_t straight) {
  costs.straight[cost] = static_cast<std::uint16_t>(straight);
  costs.diagonal[cost] = as_diagonal(straight);
}

}  // namespace

StepCosts make_step_costs(const StepOptions& options) {
  StepCosts costs;
  const auto weight = [](std::uint32_t cost) { return kStraightCost + (cost * 4 + 2) / 5; };
  for (std::uint32_t cost = 0; cost < kInscribedCost; ++cost) set(costs, cost, weight(cost));
  if (options.allow_unknown) set(costs, kUnknownCost, weight(options.unknown_as));
  return costs;
}

StepCosts make_relief_costs(const StepOptions& options) {
  StepCosts costs = make_step_costs(options);
  set(costs, kInscribedCost, kReliefCost);
  return costs;
}

StepRule::StepRule(const CellGrid<std::uint8_t>& cost, Cell start, const StepOptions& options)
    : normal_(make_step_costs(options)), relief_(make_relief_costs(options)), start_(start) {
  const std::uint8_t at_start = cost.at(start);
  if (at_start == kInscribedCost || at_start == kLethalCost) relief_cells_ = options.relief_cells;
}

}  // namespace g3d::nav
