// SPDX-License-Identifier: Apache-2.0
// Maps that are larger than memory: the file for what is far, and how all of it comes together at the end.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "board/board.hpp"
#include "hal/result.hpp"
#include "main_commands.hpp"
#include "mapper/block_source.hpp"
#include "mapper/page_file.hpp"
#include "mapper/report.hpp"
#include "mapper/rolling_window.hpp"
#include "mapper/submaps/looped_map.hpp"

namespace g3d {

/// nullptr if the board asks for no window.
[[nodiscard]] hal::Result<std::unique_ptr<mapper::PageFile>> open_pages(const board::Board& board,
                                                                        const MappingOptions& options);
[[nodiscard]] std::unique_ptr<mapper::RollingWindow> make_window(mapper::Mapper& mapper, const hal::CameraModel& camera,
                                                                 const board::Board& board,
                                                                 const MappingOptions& options,
                                                                 std::unique_ptr<mapper::PageFile> pages);

/// A map after its last frame, in memory if that can hold it.
struct GatheredMap {
  std::unique_ptr<mapper::BlockSource> whole;  ///< refers to what it was gathered from
  bool is_all_in_memory = true;
  std::optional<mapper::PagingReport> paging;  ///< none without a window
  std::string first_error;                     ///< of the disk; empty if there was none
};
/// `window` and `looped` may be nullptr.
[[nodiscard]] GatheredMap gather_map(mapper::VoxelMap& map, mapper::RollingWindow* window,
                                     mapper::submaps::LoopedMap* looped);

}  // namespace g3d
