// SPDX-License-Identifier: Apache-2.0
// FrameParams and FrameTables of a posed frame. The host computes them with the CPU twin's own functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapper/cpu/depth_pyramid.hpp"
#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cuda/frame_params.hpp"
#include "mapper/cuda/memory.hpp"
#include "mapper/mapper.hpp"

namespace g3d::mapper::cuda {

class FrameBuilder {
 public:
  /// `scan_mask` as for Mapper. `sensor` outlives this.
  FrameBuilder(const MapperConfig& config, const cpu::SensorGeometry& sensor, std::span<const std::uint16_t> scan_mask);

  void fill(const cpu::FrameGeometry& frame, bool with_colour, std::uint32_t frame_number, FrameInput& input) const;

  [[nodiscard]] MemorySizes sizes() const;
  /// The free scan mask of every pixel, none beyond far_m.
  [[nodiscard]] const std::vector<std::uint16_t>& mask() const { return mask_; }

 private:
  void fill_projection(const cpu::FrameGeometry& frame, FrameParams& out, FrameTables& tables) const;

  MapperConfig config_;
  const cpu::SensorGeometry& sensor_;
  cpu::DepthPyramid pyramid_;  ///< for its shape alone
  std::vector<std::uint16_t> mask_;
};

}  // namespace g3d::mapper::cuda
