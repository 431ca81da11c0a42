// SPDX-License-Identifier: Apache-2.0
// `g3dmap merge`: several maps become one, each at its pose, or where it fits to those before it.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <thread>

#include "hal/geometry.hpp"
#include "main_commands.hpp"
#include "main_say.hpp"
#include "mapper/align/map_aligner.hpp"
#include "mapper/align/pose_step.hpp"
#include "mapper/files/any_map.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/merge.hpp"
#include "mapper/summary.hpp"
#include "nav/outputs.hpp"

namespace g3d {
namespace {

using mapper::align::MapAlignment;
using mapper::align::MapAlignOutcome;
using mapper::align::MapSurfaces;

/// "x,y,z,roll,pitch,yaw"; six finite numbers, positions within 1000 km.
std::optional<hal::Pose> parse_pose(std::string_view text) {
  std::array<double, 6> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto end = i + 1 < numbers.size() ? text.find(',') : text.size();
    if (end == std::string_view::npos) return std::nullopt;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + end, numbers[i]);
    if (error != std::errc{} || stop != text.data() + end || !std::isfinite(numbers[i]) || std::abs(numbers[i]) > 1e6) {
      return std::nullopt;
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return hal::from_xyz_rpy(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]);
}

mapper::align::MapAlignOptions reach_of(const std::string& how_well) {
  mapper::align::MapAlignOptions options;
  if (how_well == "known") {
    options.reach_m = 0.3;
    options.reach_rad = 0.1;
  }
  options.anywhere = how_well == "unknown";
  return options;
}

std::string reason(MapAlignOutcome outcome, const MapAlignment& found) {
  switch (outcome) {
    case MapAlignOutcome::too_little:
      return "one of them has hardly any surface";
    case MapAlignOutcome::little_overlap:
      return fmt::format("only {:.1f} square metres of surface are in both", found.area_m2);
    case MapAlignOutcome::contradicted:
      return fmt::format("only {:.0f} % of what both have looked at agrees", 100.0 * found.overlap);
    case MapAlignOutcome::unfixed:
      return "what they share could slide, as along a corridor";
    case MapAlignOutcome::ambiguous:
      return fmt::format("another place fits nearly as well ({:.0f} % against {:.0f} %)", 100.0 * found.runner_up,
                         100.0 * found.overlap);
    case MapAlignOutcome::aligned:
      break;
  }
  return {};
}

/// Each map is fitted to the first of those before it that it clearly overlaps; the first stays where it is.
hal::Result<void> align_sources(const MergeOptions& options, std::vector<mapper::MergeSource>& sources) {
  std::vector<std::unique_ptr<MapSurfaces>> surfaces;
  surfaces.reserve(sources.size());
  for (const mapper::MergeSource& source : sources) surfaces.push_back(std::make_unique<MapSurfaces>(*source.map));
  for (std::size_t i = 1; i < sources.size(); ++i) {
    std::optional<MapAlignment> best;
    std::size_t to = 0;
    for (std::size_t k = 0; k < i; ++k) {
      const hal::Pose guess = hal::compose(hal::inverse(sources[k].T_world_map), sources[i].T_world_map);
      const MapAlignment found = align_maps(*surfaces[k], *surfaces[i], guess, reach_of(options.align));
      const bool is_better = !best || (found.outcome == MapAlignOutcome::aligned &&
                                       (best->outcome != MapAlignOutcome::aligned || found.area_m2 > best->area_m2));
      if (!is_better) continue;
      best = found;
      to = k;
    }
    if (best->outcome != MapAlignOutcome::aligned) {
      return hal::Error{hal::Reason::out_of_range,
                        fmt::format("{}: does not fit to the maps before it: {}; nothing was written. Give its pose "
                                    "with --pose and leave --align out, or map more of what they share",
                                    options.maps[i], reason(best->outcome, *best))};
    }
    const hal::Pose T_world_map = hal::compose(sources[to].T_world_map, best->T_a_b);
    const mapper::align::Vector6 by = mapper::align::difference(sources[i].T_world_map, T_world_map);
    sources[i].T_world_map = T_world_map;
    fmt::print(
        "{}  fits {} at {:.3f} {:.3f} {:.3f} m, turned by {:.2f} degrees: {:.0f} % of {:.1f} square metres agree "
        "to {:.1f} mm, next best {:.0f} %\n",
        options.maps[i], options.maps[to], T_world_map.translation_m[0], T_world_map.translation_m[1],
        T_world_map.translation_m[2], mapper::align::turn_of(by) * 180.0 / std::numbers::pi, 100.0 * best->overlap,
        best->area_m2, 1e3 * best->residual_m, 100.0 * best->runner_up);
  }
  return {};
}

}  // namespace

int run_merge(const MergeOptions& options) {
  if (!options.poses.empty() && options.poses.size() != options.maps.size()) {
    return fail(fmt::format("{} maps but {} poses; give one --pose per map, or none", options.maps.size(),
                            options.poses.size()),
                kExitBadUsage);
  }
  std::vector<mapper::AnyMap> maps;
  std::vector<mapper::MergeSource> sources;
  for (std::size_t i = 0; i < options.maps.size(); ++i) {
    auto any = mapper::read_any_map(options.maps[i]);
    if (!any) return fail(any.error().text);
    hal::Pose pose = any.value().meta.T_world_map;
    if (!options.poses.empty()) {
      const auto given = parse_pose(options.poses[i]);
      if (!given) {
        return fail(
            fmt::format("--pose '{}': not x,y,z,roll,pitch,yaw with six numbers (metres, radians)", options.poses[i]),
            kExitBadUsage);
      }
      pose = *given;
    }
    maps.push_back(std::move(any).value());
    sources.push_back({maps.back().map.get(), pose, maps.back().meta.layer_id});
  }
  if (!options.align.empty()) {
    if (const auto placed = align_sources(options, sources); !placed) return fail(placed.error().text);
  }
  mapper::MergeOptions merging;
  merging.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const auto merged = mapper::merge_maps(sources, merging);
  if (!merged) return fail(merged.error().text);
  const auto written = nav::write_as(*merged.value(), {}, options.out);
  if (!written) return fail(written.error().text);
  const mapper::MapCounts counts = merged.value()->counts();
  fmt::print("{}  {}  {} occupied and {} free voxels out of {} maps\nhash {}\n", written.value().path,
             mapper::readable_bytes(written.value().bytes), mapper::readable_count(counts.occupied),
             mapper::readable_count(counts.free), options.maps.size(), map_hash(*merged.value()));
  return kExitDone;
}

}  // namespace g3d
