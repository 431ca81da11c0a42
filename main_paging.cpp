// SPDX-License-Identifier: Apache-2.0
#include "main_paging.hpp"

#include <utility>

namespace g3d {
namespace {

/// What both kinds of window count; `disk`: who counts what failed there.
template <typename Window, typename Disk>
mapper::PagingReport paging_report(const Window& window, const Disk& disk, std::uint64_t file_bytes) {
  const auto& counts = window.counts();
  return {.radius_m = window.full_radius_m(),
          .smallest_radius_m = counts.smallest_radius_m,
          .regions_out = counts.regions_out,
          .regions_in = counts.regions_in,
          .blocks_out = counts.blocks_out,
          .blocks_in = counts.blocks_in,
          .failed_stores = disk.failed_stores,
          .failed_loads = disk.failed_loads,
          .page_file_bytes = file_bytes};
}

mapper::PagingReport paging_report(mapper::RollingWindow& window) {
  auto report = paging_report(window, window.counts(), window.store().file_bytes());
  report.regions_on_disk = window.store().region_count();
  report.late_regions = window.counts().late_regions;
  return report;
}

mapper::PagingReport paging_report(mapper::submaps::LoopedMap& looped) {
  const mapper::submaps::ShelfCounts& shelf = looped.shelf().counts();
  auto report = paging_report(looped.window(), shelf, looped.shelf().file_bytes());
  report.regions_on_disk = looped.window().out_count();
  report.submaps_out = shelf.put_away;
  report.submaps_in = shelf.fetched;
  report.submaps_on_disk = looped.chain().submaps().size() - looped.chain().in_memory();
  return report;
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
