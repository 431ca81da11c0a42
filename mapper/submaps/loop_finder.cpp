// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/loop_finder.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::submaps {
namespace {

constexpr std::size_t kAround = 2;   // submaps before and after the old one
constexpr std::uint32_t kApart = 3;  // candidates nearer to each other in the chain are one place
constexpr double kLeastArea_m2 = 2.0;

/// A part of the chain, ready to be fitted.
class Part {
 public:
  Part(const SubmapChain& chain, std::size_t first, std::size_t end, std::size_t at)
      : shown_(chain.surroundings(first, end, at)) {
    if (shown_.space != nullptr) surfaces_.emplace(*shown_.space, shown_.surfaces);
  }
  /// Where `other` stands in this one.
  [[nodiscard]] align::MapAlignment fit(const Part& other, const hal::Pose& T_guess,
                                        const FinderOptions& options) const {
    if (!surfaces_ || !other.surfaces_) return {};
    align::MapAlignOptions how;
    how.reach_m = options.reach_m;
    how.reach_rad = options.reach_rad;
    how.least_area_m2 = kLeastArea_m2;
    return align_maps(*surfaces_, *other.surfaces_, T_guess, how);
  }

 private:
  Surroundings shown_;
  std::optional<align::MapSurfaces> surfaces_;
};

}  // namespace

std::vector<std::uint32_t> LoopFinder::candidates(const SubmapChain& chain) const {
  const auto submaps = chain.submaps();
  const hal::Pose here = submaps.back().T_world_anchor();
  std::vector<std::pair<double, std::uint32_t>> near;
  for (std::size_t i = 0; i + options_.least_age < submaps.size(); ++i) {
    double distance_m = std::numeric_limits<double>::infinity();
    for (const hal::Pose& station : submaps[i].T_stored_stations) {
      const hal::Pose there = hal::compose(submaps[i].T_world_stored, station);
      distance_m = std::min(distance_m, align::shift_of(align::difference(there, here)));
    }
    if (distance_m <= options_.most_distance_m) near.emplace_back(distance_m, static_cast<std::uint32_t>(i));
  }
  std::sort(near.begin(), near.end());
  std::vector<std::uint32_t> chosen;
  for (const auto& [distance_m, i] : near) {
    const bool is_new =
        std::none_of(chosen.begin(), chosen.end(), [i = i](std::uint32_t j) { return submaps_apart(i, j) < kApart; });
    if (is_new) chosen.push_back(i);
    if (chosen.size() == options_.most_candidates) break;
  }
  return chosen;
}

std::vector<Loop> LoopFinder::find(const SubmapChain& chain) {
  std::vector<Loop> loops;
  if (chain.submaps().empty()) return loops;
  const std::vector<std::uint32_t> places = candidates(chain);
  if (places.empty()) return loops;
  const std::size_t newest = chain.submaps().size() - 1;
  const hal::Pose here = chain.submaps()[newest].T_world_anchor();
  const Part now(chain, newest - 1, newest + 1, newest);
  const Part newest_alone(chain, newest, newest + 1, newest);
  for (const std::uint32_t i : places) {
    ++report_.tried;
    const std::size_t first = i >= kAround ? i - kAround : 0;
    const std::size_t end = std::min<std::size_t>(i + kAround + 1, newest - options_.least_age + 1);
    const hal::Pose guess = hal::compose(hal::inverse(chain.submaps()[i].T_world_anchor()), here);
    const align::MapAlignment all = Part(chain, first, end, i).fit(now, guess, options_);
    if (all.outcome != align::MapAlignOutcome::aligned) {
      ++report_.refused;
      continue;
    }
    const Part fewer(chain, i >= 1 ? i - 1 : 0, std::min<std::size_t>(i + 2, end), i);
    const align::MapAlignment less = fewer.fit(newest_alone, guess, options_);
    const align::Vector6 apart = align::difference(all.T_a_b, less.T_a_b);
    if (less.outcome != align::MapAlignOutcome::aligned || align::shift_of(apart) > options_.most_apart_m ||
        align::turn_of(apart) > options_.most_apart_rad) {
      ++report_.not_again;
      continue;
    }
    ++report_.found;
    loops.push_back({i, static_cast<std::uint32_t>(newest), all.T_a_b, std::min(all.overlap, less.overlap)});
  }
  return loops;
}

}  // namespace g3d::mapper::submaps
