// SPDX-License-Identifier: Apache-2.0
// GPIO lines that do as a test says; set from one thread, read by another.
#pragma once

#include <array>
#include <atomic>
#include <mutex>
#include <optional>
#include <vector>

#include "hal/gpio/gpio_lines.hpp"

namespace g3d::test {

class ScriptedGpio final : public hal::GpioLines {
 public:
  explicit ScriptedGpio(std::size_t inputs = 1, bool level = true) : inputs_(inputs) {
    for (auto& one : levels_) one.store(level ? 1 : 0);
  }
  /// An edge as the kernel would have stamped it.
  void set(bool level, hal::TimeNs t_ns, std::uint8_t input = 0) {
    const std::lock_guard lock(mutex_);
    levels_[input].store(level ? 1 : 0);
    edges_.push_back({t_ns, input, level});
  }
  void set_unreadable(bool unreadable) { unreadable_.store(unreadable); }
  [[nodiscard]] int output() const { return output_.load(); }

  std::size_t input_count() const override { return inputs_; }
  bool read_edge(hal::GpioEdge& edge, hal::TimeNs) override {
    const std::lock_guard lock(mutex_);
    if (edges_.empty()) return false;
    edge = edges_.front();
    edges_.erase(edges_.begin());
    ++counts_.edges;
    return true;
  }
  std::optional<bool> level(std::size_t input) override {
    if (unreadable_.load()) {
      ++counts_.failed_reads;
      return std::nullopt;
    }
    return levels_[input].load() == 1;
  }
  void set_output(bool level) override { output_.store(level ? 1 : 0); }
  const hal::GpioCounts& counts() const override { return counts_; }

 private:
  const std::size_t inputs_;
  std::mutex mutex_;
  std::vector<hal::GpioEdge> edges_;
  std::array<std::atomic<int>, hal::kMaxGpioInputs> levels_{};
  std::atomic<bool> unreadable_{false};
  std::atomic<int> output_{-1};  ///< -1: never set
  hal::GpioCounts counts_;
};

}  // namespace g3d::test
