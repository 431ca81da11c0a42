// SPDX-License-Identifier: Apache-2.0
// What a search remembers of every cell: the cheapest way so far and the step that it ends with. Nothing is cleared
// between searches: a label is `top - g`, and each search has a higher top, so that whatever older ones left behind
// compares as farther than anything new. 64 searches later the memory is wiped once.
#pragma once

#include <cstdint>
#include <cstring>

#include "mapper/pool.hpp"

namespace g3d::nav {

class SearchLabels {
 public:
  /// Costs stay below this (67 km of free floor at 5 cm).
  static constexpr std::uint32_t kRange = 1U << 26;

  explicit SearchLabels(std::size_t max_cells) : labels_(max_cells), steps_(max_cells) {}

  [[nodiscard]] std::size_t size() const { return labels_.size(); }

  /// Forgets the last search.
  void begin() {
    if (top_ > ~std::uint32_t{0} - kRange) {
      std::memset(labels_.data(), 0, labels_.size() * sizeof(std::uint32_t));
      top_ = 0;
    }
    top_ += kRange;
  }
  /// Takes the way of cost `g` if it is cheaper than what is known. g < kRange.
  bool improve(std::uint32_t index, std::uint32_t g, std::uint32_t direction) {
    const std::uint32_t label = top_ - g;
    if (labels_[index] >= label) return false;
    labels_[index] = label;
    steps_[index] = static_cast<std::uint8_t>(direction);
    return true;
  }
  /// Of a reached cell: true the first time.
  bool close(std::uint32_t index) {
    if ((steps_[index] & kClosed) != 0) return false;
    steps_[index] |= kClosed;
    return true;
  }

  [[nodiscard]] bool is_reached(std::uint32_t index) const { return labels_[index] > top_ - kRange; }
  [[nodiscard]] bool is_closed(std::uint32_t index) const {
    return is_reached(index) && (steps_[index] & kClosed) != 0;
  }
  // Of a reached cell:
  [[nodiscard]] std::uint32_t g(std::uint32_t index) const { return top_ - labels_[index]; }
  [[nodiscard]] std::uint32_t direction(std::uint32_t index) const { return steps_[index] & kDirection; }

 private:
  static constexpr std::uint8_t kDirection = 7, kClosed = 8;
  mapper::ReservedArray<std::uint32_t> labels_;
  mapper::ReservedArray<std::uint8_t> steps_;
  std::uint32_t top_ = 0;
};

/// A cell in one word, for queues. Sides of grids are below 65536 cells.
[[nodiscard]] constexpr std::uint32_t packed(int x, int y) {
  return static_cast<std::uint32_t>(y) << 16 | static_cast<std::uint32_t>(x);
}
[[nodiscard]] constexpr int packed_x(std::uint32_t cell) { return static_cast<int>(cell & 0xFFFFU); }
[[nodiscard]] constexpr int packed_y(std::uint32_t cell) { return static_cast<int>(cell >> 16); }

}  // namespace g3d::nav
