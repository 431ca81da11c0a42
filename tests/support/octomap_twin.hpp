// SPDX-License-Identifier: Apache-2.0
// The real liboctomap fed with our points, with our steps and clamps: hit +4, miss -2, levels 0..32 around 16. As
// `insertPointCloud(discretize=false)` does: rays free what they pass, ends are occupied, an end beats any ray of the
// same frame; rays that were cut off at the far bound free up to their end.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "mapper/voxel_map.hpp"
#include "tests/support/ray_list.hpp"

namespace g3d::test {

/// How far a map of ours and OctoMap's go together, counted in voxels.
struct Agreement {
  std::uint64_t known = 0;  ///< to either, without ties
  std::uint64_t same = 0;   ///< of these, in the same state
  std::uint64_t ties = 0;   ///< OctoMap rests on 16, where we never do: counted apart
  std::uint64_t only_ours = 0;
  std::uint64_t only_theirs = 0;
  std::uint64_t other_state = 0;  ///< free here, occupied there
  // What differs, by how near to the voxel's boundary a ray passes or ends: there float and double part.
  std::uint64_t grazed = 0;  ///< within kGraze_cells
  std::uint64_t deep = 0;    ///< nothing explains it
  [[nodiscard]] double share() const {
    return known == 0 ? 0.0 : static_cast<double>(same) / static_cast<double>(known);
  }
};
inline constexpr double kGraze_cells = 0.02;
[[nodiscard]] std::string describe(const Agreement& agreement);

class OctomapTwin {
 public:
  explicit OctomapTwin(float resolution_m);
  ~OctomapTwin();
  OctomapTwin(const OctomapTwin&) = delete;
  OctomapTwin& operator=(const OctomapTwin&) = delete;

  void integrate(const RayList& rays);
  [[nodiscard]] Agreement compare(const mapper::VoxelMap& map) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace g3d::test
