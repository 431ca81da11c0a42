// SPDX-License-Identifier: Apache-2.0
// Where one robot's map stands in another's: from poses that are known, roughly known, or not at all. The two have to
// show the same surfaces where they overlap, and neither may show a surface where the other has seen free space; else
// the answer is a refusal with its reason, for a wrong merge spoils both maps.
//
// Rough guesses are tried on a grid of turns and shifts on the floor, scored by how much surface falls onto surface in
// coarse cells; the best are refined by point-to-plane least squares, coarse, then fine.
#pragma once

#include <cstdint>

#include "hal/geometry.hpp"
#include "mapper/align/map_surfaces.hpp"

namespace g3d::mapper::align {

enum class MapAlignOutcome : std::uint8_t {
  aligned,
  too_little,      ///< one of them has hardly any surface
  little_overlap,  ///< too little of what one shows lies where the other has been
  contradicted,    ///< one shows surfaces where the other has seen free space
  unfixed,         ///< they could slide along each other, as corridors do
  ambiguous,       ///< another place fits nearly as well
};
[[nodiscard]] const char* to_string(MapAlignOutcome outcome);

struct MapAlignOptions {
  double reach_m = 1.2;         ///< how far off the guess may be, each way on the floor
  double reach_rad = 0.6;       ///< and how far turned
  bool anywhere = false;        ///< the guess says nothing
  double least_overlap = 0.93;  ///< of the surfaces that both have looked at
  double least_area_m2 = 3.0;   ///< of surface that both show
};

struct MapAlignment {
  MapAlignOutcome outcome = MapAlignOutcome::too_little;
  hal::Pose T_a_b;          ///< the best that was found, accepted or not
  double overlap = 0.0;     ///< share of agreeing surface where both have looked, the worse of both ways
  double area_m2 = 0.0;     ///< of surface that both show
  double residual_m = 0.0;  ///< root mean square
  double hold = 0.0;        ///< share of the surface that faces along the weakest direction, up to a half
  double runner_up = 0.0;   ///< overlap of the best answer elsewhere, 0 if there is none
  std::uint64_t tried = 0;  ///< places
};

[[nodiscard]] MapAlignment align_maps(const MapSurfaces& a, const MapSurfaces& b, const hal::Pose& T_a_b_guess,
                                      const MapAlignOptions& options = {});

}  // namespace g3d::mapper::align
