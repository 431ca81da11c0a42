// SPDX-License-Identifier: Apache-2.0
#include "mapper/block_merge.hpp"

namespace g3d::mapper {

void merge_into(BlockValues& newer, const BlockValues& older) {
  for (std::size_t i = 0; i < newer.size(); ++i) newer[i] = merged_value(older[i], newer[i]);
}

std::size_t merge_lists(std::span<const StoredBlock> older, std::span<const StoredBlock> newer,
                        std::span<StoredBlock> out) {
  std::size_t count = 0;
  for (std::size_t o = 0, n = 0; o < older.size() || n < newer.size(); ++count) {
    const bool take_older = o < older.size() && (n == newer.size() || older[o].key <= newer[n].key);
    const bool take_newer = n < newer.size() && (o == older.size() || newer[n].key <= older[o].key);
    out[count] = take_newer ? newer[n] : older[o];
    if (take_older && take_newer) merge_into(out[count].values, older[o].values);
    o += take_older ? 1 : 0;
    n += take_newer ? 1 : 0;
  }
  return count;
}

}  // namespace g3d::mapper
