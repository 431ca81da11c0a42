// SPDX-License-Identifier: Apache-2.0
// A map on an emulated card, and its mirror: what Mapper is with a card, without the helper process.
#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <span>

#include "mapper/cuda/emulated.hpp"
#include "mapper/cuda/twin.hpp"
#include "mapper/mapper.hpp"

namespace g3d::test {

struct EmulatedMapper {
  EmulatedMapper(const mapper::MapperConfig& settings, const hal::CameraModel& camera, std::uint64_t seed,
                 std::span<const std::uint16_t> mask = {})
      : config(settings),
        sensor(camera, settings.resolution_m, settings.near_m, settings.far_m),
        map(mapper::Grid{settings.resolution_m}, settings.capacity),
        twin(settings, sensor, mask, map) {
    new_card(seed);
  }
  void new_card(std::uint64_t seed) {
    card = std::make_shared<mapper::cuda::Emulated>(twin.builder().sizes(), sensor.column_slope, sensor.row_slope,
                                                    twin.builder().mask(), seed);
    twin.set_card(card);
  }
  mapper::FrameReport integrate(const hal::Frame& frame, const hal::Pose& pose) {
    mapper::FrameReport report;
    const auto geometry = mapper::cpu::frame_geometry(sensor, hal::to_transform(pose));
    REQUIRE(geometry);
    REQUIRE(twin.integrate(frame, *geometry, config.with_colour && frame.has_colour, ++frame_number, report));
    return report;
  }

  mapper::MapperConfig config;
  mapper::cpu::SensorGeometry sensor;
  mapper::VoxelMap map;
  mapper::cuda::Twin twin;
  std::shared_ptr<mapper::cuda::Emulated> card;
  std::uint32_t frame_number = 0;
};

}  // namespace g3d::test
