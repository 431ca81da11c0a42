// SPDX-License-Identifier: Apache-2.0
#include "mapper/region_table.hpp"

#include <cassert>

namespace g3d::mapper {

RegionState* RegionTable::add_resident(RegionKey region) {
  RegionState* state = table_.find_or_insert(region);
  if (state == nullptr || state->resident()) return state;
  state->place = static_cast<std::uint32_t>(resident_count_);
  resident_[resident_count_++] = region;
  return state;
}

void RegionTable::remove_resident(RegionKey region) {
  RegionState* state = table_.find(region);
  assert(state != nullptr && state->resident());
  const std::uint32_t place = state->place;
  state->place = RegionState::kNotResident;
  const RegionKey last = resident_[--resident_count_];
  if (last != region) {
    resident_[place] = last;
    table_.find(last)->place = place;
  }
  if (!state->on_disk) table_.erase(region);
}

}  // namespace g3d::mapper
