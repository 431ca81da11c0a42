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
  [[nodiscard]] align::MapAlignment fit(const Part& other, const hal::Pose& T_guess, double reach_m,
                                        double reach_rad) const {
    if (!surfaces_ || !other.surfaces_) return {};
    align::MapAlignOptions how;
    how.reach_m = reach_m;
    how.reach_rad = reach_rad;
    how.least_area_m2 = kLeastArea_m2;
    return align_maps(*surfaces_, *other.surfaces_, T_guess, how);
  }

 private:
  Surroundings shown_;
  std::optional<align::MapSurfaces> surfaces_;
};

}  // namespace

std::vector<LoopFinder::Candidate> LoopFinder::near_candidates(const SubmapChain& chain) const {
  const auto submaps = chain.submaps();
  const hal::Pose here = submaps.back().T_world_anchor();
  std::vector<std::pair<double, std::uint32_t>> near;
  for (std::size_t i = 0; i + options_.least_age < submaps.size(); ++i) {
    double distance_m = std::numeric_limits<double>::infinity();
    for (const Submap::Station& station : submaps[i].stations) {
      const hal::Pose there = hal::compose(submaps[i].T_world_stored, station.T_stored_station);
      distance_m = std::min(distance_m, align::shift_of(align::difference(there, here)));
    }
    if (distance_m <= options_.most_distance_m) near.emplace_back(distance_m, static_cast<std::uint32_t>(i));
  }
  std::sort(near.begin(), near.end());
  std::vector<Candidate> chosen;
  for (const auto& [distance_m, i] : near) {
    const bool is_new = std::none_of(chosen.begin(), chosen.end(),
                                     [i = i](const Candidate& c) { return submaps_apart(i, c.submap) < kApart; });
    if (!is_new) continue;
    chosen.push_back(
        {i, hal::compose(hal::inverse(submaps[i].T_world_anchor()), here), options_.reach_m, options_.reach_rad});
    if (chosen.size() == options_.most_candidates) break;
  }
  return chosen;
}

std::optional<LoopFinder::Candidate> LoopFinder::alike_candidate(const SubmapChain& chain,
                                                                 const std::vector<Candidate>& tried) const {
  const auto submaps = chain.submaps();
  const Submap& newest = submaps.back();
  const Submap::Station& here = newest.stations.front();
  std::optional<Candidate> best;
  double least = options_.least_likeness;
  for (std::size_t i = 0; i + options_.least_age < submaps.size(); ++i) {
    const auto submap = static_cast<std::uint32_t>(i);
    if (std::any_of(tried.begin(), tried.end(), [&](const Candidate& c) { return c.submap == submap; })) continue;
    for (const Submap::Station& station : submaps[i].stations) {
      const PlaceSketch::Likeness likeness = station.sketch.likeness(here.sketch);
      if (likeness.share < least) continue;
      least = likeness.share;
      const hal::Pose T_station_here = hal::from_xyz_rpy(0, 0, 0, 0, 0, likeness.turn_rad);
      const hal::Pose T_anchor_station =
          hal::compose(hal::inverse(submaps[i].T_stored_anchor), station.T_stored_station);
      const hal::Pose T_here_anchor = hal::compose(hal::inverse(here.T_stored_station), newest.T_stored_anchor);
      best = {submap, hal::compose(hal::compose(T_anchor_station, T_station_here), T_here_anchor),
              options_.likeness_reach_m, options_.likeness_reach_rad};
    }
  }
  return best;
}

std::vector<Loop> LoopFinder::find(const SubmapChain& chain) {
  std::vector<Loop> loops;
  if (chain.submaps().size() <= options_.least_age) return loops;
  const std::vector<Candidate> candidates = near_candidates(chain);
  const std::size_t newest = chain.submaps().size() - 1;
  std::optional<Part> now;
  std::optional<Part> newest_alone;
  const auto try_it = [&](const Candidate& candidate) {
    if (!now) now.emplace(chain, newest - 1, newest + 1, newest);
    if (!newest_alone) newest_alone.emplace(chain, newest, newest + 1, newest);
    const std::uint32_t i = candidate.submap;
    ++report_.tried;
    const std::size_t first = i >= kAround ? i - kAround : 0;
    const std::size_t end = std::min<std::size_t>(i + kAround + 1, newest - options_.least_age + 1);
    const align::MapAlignment all =
        Part(chain, first, end, i).fit(*now, candidate.T_guess, candidate.reach_m, candidate.reach_rad);
    if (all.outcome != align::MapAlignOutcome::aligned) {
      ++report_.refused;
      return;
    }
    const Part fewer(chain, i >= 1 ? i - 1 : 0, std::min<std::size_t>(i + 2, end), i);
    const align::MapAlignment less =
        fewer.fit(*newest_alone, candidate.T_guess, candidate.reach_m, candidate.reach_rad);
    const align::Vector6 apart = align::difference(all.T_a_b, less.T_a_b);
    if (less.outcome != align::MapAlignOutcome::aligned || align::shift_of(apart) > options_.most_apart_m ||
        align::turn_of(apart) > options_.most_apart_rad) {
      ++report_.not_again;
      return;
    }
    ++report_.found;
    loops.push_back({i, static_cast<std::uint32_t>(newest), all.T_a_b, std::min(all.hold, less.hold)});
  };
  for (const Candidate& candidate : candidates) try_it(candidate);
  if (!loops.empty()) return loops;
  if (const auto alike = alike_candidate(chain, candidates)) {
    ++report_.alike;
    try_it(*alike);
  }
  return loops;
}

}  // namespace g3d::mapper::submaps
