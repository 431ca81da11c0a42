// SPDX-License-Identifier: Apache-2.0
// What gpu_bench and gpu_align_bench share: a map in a card with its measuring helper, titles, and the count of
// failures.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mapper/cuda/carried.hpp"
#include "mapper/cuda/helper_process.hpp"
#include "mapper/cuda/twin.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/workload.hpp"

namespace g3d::bench {

using namespace g3d::mapper;

inline int failures = 0;

inline struct RigOptions {
  std::uint32_t update_warps = 0;
  std::string kernels;                       ///< PTX instead of what is carried
  std::string helper;                        ///< an executable instead of what is carried
  hal::TimeNs patience_ns = 60'000'000'000;  ///< a profiler may take its time
} rig_options;

inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

inline std::string title(const MapperConfig& config, const test::Workload& work) {
  return fmt::format("{} {} {} {:.3f} m, {} frames", work.name, to_string(config.integrator), to_string(config.mode),
                     config.resolution_m, work.frames.size());
}

/// A map in a card with its measuring helper.
struct Rig {
  Rig(const mapper::MapperConfig& settings, const hal::CameraModel& camera, std::uint32_t processors = 0)
      : config(settings),
        sensor(camera, settings.resolution_m, settings.near_m, settings.far_m),
        map(Grid{settings.resolution_m}, settings.capacity),
        twin(settings, sensor, {}, map) {
    std::string problem;
    helper = cuda::HelperProcess::start(
        {.program = rig_options.helper.empty() ? cuda::carried_helper() : std::as_bytes(std::span(rig_options.helper)),
         .kernels = rig_options.kernels.empty() ? cuda::carried_kernels() : rig_options.kernels,
         .sizes = twin.builder().sizes(),
         .column_slope = sensor.column_slope,
         .row_slope = sensor.row_slope,
         .mask = twin.builder().mask(),
         .update_warps = rig_options.update_warps,
         .processors = processors,
         .patience_ns = rig_options.patience_ns},
        problem);
    if (helper != nullptr && helper->wait_started(rig_options.patience_ns) == cuda::HelperState::ready)
      twin.set_card(helper);
    if (twin.has_card() && !helper->note().empty()) {
      fmt::print("note    {} multiprocessors wanted, {} used: {}\n", processors, helper->processors(), helper->note());
    }
    if (!twin.has_card()) fmt::print("no card: {}\n", helper != nullptr ? helper->problem() : problem);
  }
  FrameReport integrate(const hal::Frame& frame, const hal::Pose& pose) {
    FrameReport report;
    const auto geometry = cpu::frame_geometry(sensor, hal::to_transform(pose));
    if (!geometry || !twin.integrate(frame, *geometry, frame.has_colour, ++frame_number, report)) {
      fmt::print("frame {} failed: {}\n", frame_number, helper->problem());
      ++failures;
    }
    return report;
  }
  MapperConfig config;
  cpu::SensorGeometry sensor;
  VoxelMap map;
  cuda::Twin twin;
  std::shared_ptr<cuda::HelperProcess> helper;
  std::uint32_t frame_number = 0;
};

}  // namespace g3d::bench
