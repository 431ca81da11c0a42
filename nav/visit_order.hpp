// SPDX-License-Identifier: Apache-2.0
// An order of visits in which what they are worth comes early and the whole is short: insertion, then 2-opt and or-opt
// while they help. For a few dozen visits. One thread; sized by reset().
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nav/work_budget.hpp"

namespace g3d::nav {

class VisitOrder {
 public:
  struct Config {
    double length_weight = 0.3;  ///< of the whole time, against the mean time at which something is seen
    double keep_s = 6.0;         ///< how much better it must be not to begin with the first visit, when that is kept
    int passes = 6;
  };

  void reset(std::size_t max_visits, const Config& config);
  /// Visits are 1..n, 0 is where it begins. All times must be set then.
  void begin(std::size_t visits, bool keeps_first);
  void set_seconds(std::size_t from, std::size_t to, double seconds) {
    seconds_[from * stops_ + to] = static_cast<float>(seconds);
  }
  void set_worth(std::size_t visit, double worth) { worth_[visit] = worth; }
  [[nodiscard]] double seconds(std::size_t from, std::size_t to) const {
    return static_cast<double>(seconds_[from * stops_ + to]);
  }
  /// Until it says true.
  [[nodiscard]] bool go_on(WorkBudget& budget);
  [[nodiscard]] std::span<const std::uint16_t> order() const { return order_; }
  [[nodiscard]] bool keeps_first() const { return keeps_first_ && order_.front() == 1; }

 private:
  [[nodiscard]] double price(std::span<const std::uint16_t> order) const;
  void insert(std::size_t visit);
  void improve(std::size_t i);
  void keep_if_better();

  Config config_;
  std::size_t stops_ = 1;
  bool keeps_first_ = false;
  std::vector<float> seconds_;  ///< stops squared
  std::vector<double> worth_;
  std::vector<std::uint16_t> order_;
  std::vector<std::uint16_t> trial_;
  double best_ = 0.0;
  int pass_ = 0;
  std::size_t next_ = 0;  ///< place in the order that this pass is at
  bool is_better_ = true;
};

}  // namespace g3d::nav
