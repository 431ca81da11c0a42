// SPDX-License-Identifier: Apache-2.0
#include "main_paging.hpp"

#include <utility>

namespace g3d {
namespace {

mapper::PagingReport paging_report(mapper::RollingWindow& window) {
  const mapper::WindowCounts& counts = window.counts();
  return {.radius_m = window.full_radius_m(),
          .smallest_radius_m = counts.smallest_radius_m,
          .regions_out = counts.regions_out,
          .regions_in = counts.regions_in,
          .blocks_out = counts.blocks_out,
          .blocks_in = counts.blocks_in,
          .regions_on_disk = window.store().region_count(),
          .late_regions = counts.late_regions,
          .failed_stores = counts.failed_stores,
          .failed_loads = counts.failed_loads,
          .page_file_bytes = window.store().file_bytes()};
}

mapper::PagingReport paging_report(mapper::submaps::LoopedMap& looped) {
  const mapper::submaps::ViewWindowCounts& counts = looped.window().counts();
  const mapper::submaps::ShelfCounts& shelf = looped.shelf().counts();
  return {.radius_m = looped.window().full_radius_m(),
          .smallest_radius_m = counts.smallest_radius_m,
          .regions_out = counts.regions_out,
          .regions_in = counts.regions_in,
          .blocks_out = counts.blocks_out,
          .blocks_in = counts.blocks_in,
          .regions_on_disk = looped.window().out_count(),
          .submaps_out = shelf.put_away,
          .submaps_in = shelf.fetched,
          .submaps_on_disk = looped.chain().submaps().size() - looped.chain().in_memory(),
          .failed_stores = shelf.failed_stores,
          .failed_loads = shelf.failed_loads,
          .page_file_bytes = looped.shelf().file_bytes()};
}

}  // namespace

hal::Result<std::unique_ptr<mapper::PageFile>> open_pages(const board::Board& board, const MappingOptions& options) {
  if (board.map_window_radius_m <= 0.0) return std::unique_ptr<mapper::PageFile>{};
  return mapper::create_page_file(options.out_dir);
}

std::unique_ptr<mapper::RollingWindow> make_window(mapper::Mapper& mapper, const hal::CameraModel& camera,
                                                   const board::Board& board, const MappingOptions& options,
                                                   std::unique_ptr<mapper::PageFile> pages) {
  mapper::WindowConfig config;
  config.radius_m = board.map_window_radius_m;
  config.lockstep = options.rate <= 0.0;
  return std::make_unique<mapper::RollingWindow>(mapper, camera, config, std::move(pages));
}

GatheredMap gather_map(mapper::VoxelMap& map, mapper::RollingWindow* window, mapper::submaps::LoopedMap* looped) {
  GatheredMap gathered;
  if (window != nullptr) {
    window->finish();
    gathered.paging = paging_report(*window);
    gathered.is_all_in_memory = gather(map, window->store());
    gathered.whole = std::make_unique<mapper::WindowedBlocks>(map, window->store());
    gathered.first_error = window->first_error();
  } else if (looped != nullptr && looped->is_windowed()) {
    gathered.paging = paging_report(*looped);
    gathered.is_all_in_memory = looped->window().gather();
    gathered.whole = std::make_unique<mapper::submaps::SubmapBlocks>(looped->whole_map());
    gathered.first_error = looped->shelf().first_error();
  } else {
    gathered.whole = std::make_unique<mapper::MemoryBlocks>(map);
  }
  return gathered;
}

}  // namespace g3d
