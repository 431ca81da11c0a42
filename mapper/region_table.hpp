// SPDX-License-Identifier: Apache-2.0
// What the rolling window knows of each region: whether it has blocks in memory, a record on disk, or both. Memory is
// reserved at start. Thread: mapper thread.
#pragma once

#include <cstdint>
#include <span>

#include "mapper/fixed_table.hpp"
#include "mapper/region.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

struct RegionState {
  static constexpr std::uint32_t kNotResident = 0xFFFFFFFFU;
  std::uint32_t place = kNotResident;  ///< in the list of resident regions
  bool on_disk = false;
  bool busy = false;         ///< on its way to or from the disk
  bool touched = false;      ///< changed since it was copied to be stored
  bool unreadable = false;   ///< its record is damaged: never asked for again
  std::uint16_t blocks = 0;  ///< what its record needs in memory
  std::uint16_t planes = 0;
  std::uint16_t colour_bricks = 0;

  [[nodiscard]] bool resident() const { return place != kNotResident; }
  [[nodiscard]] MapCapacity needed() const { return {blocks, planes, colour_bricks}; }
};

class RegionTable {
 public:
  explicit RegionTable(std::uint32_t max_regions) : table_(max_regions), resident_(max_regions) {}

  /// nullptr if nothing is known of it. Valid until the next call of anything below.
  [[nodiscard]] RegionState* find(RegionKey region) { return table_.find(region); }
  /// The region has blocks in memory from now on. nullptr if the table is full.
  RegionState* add_resident(RegionKey region);
  /// Its blocks are no longer in memory. A region that is not on disk either is forgotten.
  void remove_resident(RegionKey region);

  /// In no particular order.
  [[nodiscard]] std::span<const RegionKey> resident() const { return {resident_.data(), resident_count_}; }
  [[nodiscard]] std::uint32_t size() const { return table_.size(); }

 private:
  FixedTable<RegionState> table_;
  ReservedArray<RegionKey> resident_;
  std::size_t resident_count_ = 0;
};

}  // namespace g3d::mapper
