// SPDX-License-Identifier: Apache-2.0
#include "nav/visit_order.hpp"

#include <algorithm>

namespace g3d::nav {
namespace {

constexpr std::int64_t kTrial_units = 1;  // to price one order

}  // namespace

void VisitOrder::reset(std::size_t max_visits, const Config& config) {
  config_ = config;
  const std::size_t stops = max_visits + 1;
  seconds_.assign(stops * stops, 0.0F);
  worth_.assign(stops, 0.0);
  order_.clear();
  order_.reserve(stops);
  trial_.reserve(stops);
}

void VisitOrder::begin(std::size_t visits, bool keeps_first) {
  stops_ = visits + 1;
  keeps_first_ = keeps_first;
  order_.clear();
  pass_ = 0;
  next_ = 0;
  is_better_ = true;
}

double VisitOrder::price(std::span<const std::uint16_t> order) const {
  double t = 0;
  double weighted = 0;
  double weight = 0;
  std::size_t at = 0;
  for (const std::uint16_t next : order) {
    t += seconds(at, next);
    weighted += worth_[next] * t;
    weight += worth_[next];
    at = next;
  }
  const bool keeps = keeps_first_ && order[0] == 1;
  return weighted / weight + config_.length_weight * t - (keeps ? config_.keep_s : 0.0);
}

void VisitOrder::insert(std::size_t visit) {
  std::size_t best_at = 0;
  double best = 1e18;
  for (std::size_t at = 0; at <= order_.size(); ++at) {
    trial_.assign(order_.begin(), order_.end());
    trial_.insert(trial_.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint16_t>(visit));
    const double p = price(trial_);
    if (p >= best) continue;
    best = p;
    best_at = at;
  }
  order_.insert(order_.begin() + static_cast<std::ptrdiff_t>(best_at), static_cast<std::uint16_t>(visit));
}

void VisitOrder::keep_if_better() {
  const double p = price(trial_);
  if (p >= best_ - 1e-6) return;
  best_ = p;
  order_.swap(trial_);
  is_better_ = true;
}

void VisitOrder::improve(std::size_t i) {
  const std::size_t n = order_.size();
  for (std::size_t j = i + 1; j < n; ++j) {
    trial_.assign(order_.begin(), order_.end());
    std::reverse(trial_.begin() + static_cast<std::ptrdiff_t>(i), trial_.begin() + static_cast<std::ptrdiff_t>(j) + 1);
    keep_if_better();
    for (std::size_t size = 1; size <= 3 && i + size <= n; ++size) {
      for (const bool forward : {true, false}) {
        // Moves `size` stops from i behind what is then at j, or the other way round.
        trial_.assign(order_.begin(), order_.end());
        const std::size_t low = i;
        const std::size_t high = std::min(j + size, n);
        const auto first = trial_.begin() + static_cast<std::ptrdiff_t>(low);
        const auto last = trial_.begin() + static_cast<std::ptrdiff_t>(high);
        if (high - low <= size) continue;
        const auto middle =
            forward ? first + static_cast<std::ptrdiff_t>(size) : last - static_cast<std::ptrdiff_t>(size);
        std::rotate(first, middle, last);
        keep_if_better();
      }
    }
  }
}

bool VisitOrder::go_on(WorkBudget& budget) {
  const auto pieces = [this](std::size_t trials) {
    return kTrial_units * static_cast<std::int64_t>(trials * (1 + order_.size() / 4)) + 1;
  };
  while (order_.size() + 1 < stops_) {
    if (budget.is_spent()) return false;
    budget.spend(pieces(order_.size() + 1));
    insert(order_.size() + 1);
    best_ = price(order_);
  }
  while (pass_ < config_.passes && (is_better_ || next_ > 0)) {
    if (budget.is_spent()) return false;
    if (next_ == 0) is_better_ = false;
    budget.spend(pieces(7 * (order_.size() - next_)));
    improve(next_);
    if (++next_ < order_.size()) continue;
    next_ = 0;
    ++pass_;
  }
  return true;
}

}  // namespace g3d::nav
