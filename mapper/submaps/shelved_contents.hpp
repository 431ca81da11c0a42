// SPDX-License-Identifier: Apache-2.0
// What a submap holds, in memory or on the shelf until somebody asks for it. Its keys are always in memory. It never
// changes, so it is written once. What cannot be written stays in memory; what cannot be read any more is counted, and
// nothing is known there from then on. Thread: one at a time. Allocates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapper/submaps/submap_contents.hpp"
#include "mapper/submaps/submap_shelf.hpp"

namespace g3d::mapper::submaps {

class ShelvedContents {
 public:
  /// `contents` has voxels. `shelf` outlives this; nullptr: it stays in memory for good.
  explicit ShelvedContents(SubmapContents contents, SubmapShelf* shelf = nullptr);
  ~ShelvedContents();
  ShelvedContents(const ShelvedContents&) = delete;
  ShelvedContents& operator=(const ShelvedContents&) = delete;

  [[nodiscard]] const Grid& grid() const { return grid_; }
  /// Of its voxels, ascending.
  [[nodiscard]] std::span<const BlockKey> keys() const { return keys_; }
  /// Fetches it if need be. Valid until it is put away.
  [[nodiscard]] const SubmapContents& get();
  void put_away();
  [[nodiscard]] bool is_in_memory() const { return contents_.voxels != nullptr; }
  /// Grows with every use of something on the same shelf.
  [[nodiscard]] std::uint64_t last_use() const { return last_use_; }
  [[nodiscard]] std::uint64_t memory_bytes() const {
    return contents_.memory_bytes() + keys_.size() * sizeof(BlockKey);
  }

 private:
  Grid grid_;
  std::vector<BlockKey> keys_;
  SubmapContents contents_;
  SubmapShelf* shelf_;
  SubmapShelf::Number number_ = SubmapShelf::kNone;
  std::uint64_t last_use_ = 0;
};

}  // namespace g3d::mapper::submaps
