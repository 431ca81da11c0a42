// SPDX-License-Identifier: Apache-2.0
// The mapper once more, as plainly as it can be said: pixel by pixel and voxel by voxel, without block tests, pyramid,
// filtered images, vectors or threads. It shares only the grid, the frame's box and the definition of the numbers
// (float32 formulas, window sizes, bias) with the real one, and must give the same map to the last bit.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "mapper/mapper.hpp"
#include "tests/support/plain_evidence.hpp"

namespace g3d::test {

struct PlainVoxel {
  std::uint8_t level = mapper::kUnknownLevel;
  bool has_colour = false;
  std::array<std::uint8_t, 3> rgb{};
  bool operator==(const PlainVoxel&) const = default;
};
/// One frame's evidence on one voxel. `rgb`: the colour that the frame gives it, or nullptr.
void plain_update(PlainVoxel& voxel, bool hit, Seen seen, const std::uint8_t* rgb, mapper::UpdateSteps steps);

class PlainMapper {
 public:
  PlainMapper(const mapper::MapperConfig& config, const hal::CameraModel& camera,
              std::span<const std::uint16_t> scan_mask = {});

  void integrate(const hal::Frame& frame, const hal::Pose& T_world_camera);
  [[nodiscard]] std::string hash() const;
  [[nodiscard]] PlainVoxel at(mapper::MCode code) const;
  /// The first few voxels in which the map differs, in words; empty if none does.
  [[nodiscard]] std::string differences(const mapper::VoxelMap& map) const;

 private:
  using Block = std::array<PlainVoxel, mapper::kBlockVoxels>;  // keeps tests fast; nothing is decided by it
  PlainVoxel& voxel(mapper::MCode code);

  mapper::MapperConfig config_;
  mapper::cpu::SensorGeometry sensor_;
  std::vector<std::uint16_t> mask_;
  std::map<mapper::BlockKey, Block> blocks_;
};

}  // namespace g3d::test
