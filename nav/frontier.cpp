// SPDX-License-Identifier: Apache-2.0
#include "nav/frontier.hpp"

#include <algorithm>

namespace g3d::nav {

void FrontierMap::reset(const CellGrid<CellState>& ground) {
  columns_ = ground.columns;
  rows_ = ground.rows;
  cells_.clear();
  place_.assign(ground.cells.size(), kNone);
  for (int y = 0; y < rows_; ++y) {
    for (int x = 0; x < columns_; ++x) check(ground, {x, y});
  }
}

void FrontierMap::update(const CellGrid<CellState>& ground, std::span<const std::uint32_t> changed) {
  for (const std::uint32_t i : changed) {
    const Cell c = ground.cell(i);
    check(ground, c);
    check(ground, {c.x - 1, c.y});
    check(ground, {c.x + 1, c.y});
    check(ground, {c.x, c.y - 1});
    check(ground, {c.x, c.y + 1});
  }
}

void FrontierMap::check(const CellGrid<CellState>& ground, Cell c) {
  if (!ground.contains(c)) return;
  const std::size_t i = ground.index(c);
  const std::size_t row = static_cast<std::size_t>(columns_);
  const auto unknown = [&](std::size_t n) { return ground.cells[n] == CellState::unknown; };
  const bool now =
      ground.cells[i] == CellState::free && ((c.x > 0 && unknown(i - 1)) || (c.x + 1 < columns_ && unknown(i + 1)) ||
                                             (c.y > 0 && unknown(i - row)) || (c.y + 1 < rows_ && unknown(i + row)));
  std::uint32_t& place = place_[i];
  if (now == (place != kNone)) return;
  if (now) {
    place = static_cast<std::uint32_t>(cells_.size());
    cells_.push_back(static_cast<std::uint32_t>(i));
  } else {
    const std::uint32_t last = cells_.back();
    cells_[place] = last;
    place_[last] = place;
    cells_.pop_back();
    place = kNone;
  }
}

void FrontierMap::make_clusters() {
  clusters_.clear();
  clustered_.clear();
  sorted_.assign(cells_.begin(), cells_.end());
  std::sort(sorted_.begin(), sorted_.end());
  grouped_.assign(cells_.size(), 0);
  for (const std::uint32_t seed : sorted_) {
    if (grouped_[place_[seed]] != 0) continue;
    const std::uint32_t first = static_cast<std::uint32_t>(clustered_.size());
    grouped_[place_[seed]] = 1;
    clustered_.push_back(seed);
    for (std::size_t k = first; k < clustered_.size(); ++k) {
      const int x = static_cast<int>(clustered_[k]) % columns_;
      const int y = static_cast<int>(clustered_[k]) / columns_;
      for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, rows_ - 1); ++ny) {
        for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, columns_ - 1); ++nx) {
          const std::uint32_t n = static_cast<std::uint32_t>(ny * columns_ + nx);
          if (place_[n] == kNone || grouped_[place_[n]] != 0) continue;
          grouped_[place_[n]] = 1;
          clustered_.push_back(n);
        }
      }
    }
    clusters_.push_back({first, static_cast<std::uint32_t>(clustered_.size()) - first});
  }
}

}  // namespace g3d::nav
