// SPDX-License-Identifier: Apache-2.0
// Puts what a journal holds into a store: a robot's knowledge from before it was switched off. Claims are taken only as
// far as everything before them could be read and kept; a layer of which something was lost is left unclaimed, so that
// it is compared with another robot's instead of asked for from the start. One thread; cold.
#pragma once

#include <cstdint>
#include <string>

#include "hal/result.hpp"
#include "net/journal_entry.hpp"
#include "net/layer_store.hpp"

namespace g3d::net {

struct RestoreCounts {
  std::uint64_t frames = 0;
  std::uint64_t records = 0;          ///< that stood when they were read
  std::uint64_t refused_records = 0;  ///< no room, or of a robot whose layers are refused
  std::uint64_t damaged_places = 0;   ///< passed over in the middle
  std::uint64_t bad_entries = 0;      ///< frames that are whole and say nothing that can be: passed over
  std::uint64_t cut_bytes = 0;        ///< at the end, as after a power cut
};

struct RestoredJournal {
  std::uint64_t good_bytes = 0;  ///< where to go on
  RestoreCounts counts;
  /// Something in the middle was lost: it should be written anew.
  [[nodiscard]] bool is_damaged() const { return counts.damaged_places + counts.bad_entries > 0; }
};

/// Errors: not_found; those of the file; unsupported. What was read before an error stands.
[[nodiscard]] hal::Result<RestoredJournal> restore_layers(const std::string& path, LayerStore& store);

}  // namespace g3d::net
