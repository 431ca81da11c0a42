// SPDX-License-Identifier: Apache-2.0
// Alignment by a card, on a machine that has one: every pose and every cell of the surfaces as the CPU twin has them,
// bit by bit, and in how much time. `scripts/gpu-test` makes a bundle of it.
//   gpu_align_bench [--log FOLDER]... [--frames N] [--seeds N] [--resolution METRES]
// Frames of the simulated drive and of recordings, with odometry that drifts. Half of the seeds also look at the map,
// as a robot does. Times: medians and 95th percentiles of one frame; wall clock in the program from the image to the
// corrected pose (fit), until the surfaces and their mirror have the frame (all), of that the card's own part, and the
// CPU twin on one core.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/sim/pose_drift.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/cuda/align_twin.hpp"
#include "mapper/cuda/carried.hpp"
#include "mapper/cuda/helper_process.hpp"
#include "mapper/cuda/twin.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

int failures = 0;

double now_us() { return static_cast<double>(hal::RealClock().now()) * 1e-3; }

struct Times {
  std::vector<double> us;
  [[nodiscard]] double at(double share) const {
    if (us.empty()) return 0.0;
    std::vector<double> sorted = us;
    std::sort(sorted.begin(), sorted.end());
    return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
  }
  [[nodiscard]] std::string text() const { return fmt::format("{:.0f} ({:.0f})", at(0.5), at(0.95)); }
};

/// A map in a card, its mirror, and the card's part of an aligner: what Mapper has, with a watch.
struct Rig final : align::FitCard {
  Rig(const MapperConfig& config, const test::Workload& work)
      : resolution_m(config.resolution_m),
        sensor(work.camera, config.resolution_m, config.near_m, config.far_m),
        map(Grid{config.resolution_m}, config.capacity),
        twin(config, sensor, {}, map) {
    std::string problem;
    helper = cuda::HelperProcess::start({.program = cuda::carried_helper(),
                                         .kernels = cuda::carried_kernels(),
                                         .sizes = twin.builder().sizes(),
                                         .column_slope = sensor.column_slope,
                                         .row_slope = sensor.row_slope,
                                         .mask = twin.builder().mask(),
                                         .patience_ns = 60'000'000'000},
                                        problem);
    if (helper != nullptr && helper->wait_started(60'000'000'000) == cuda::HelperState::ready) twin.set_card(helper);
    check(twin.has_card());
  }
  void check(bool answered) {
    if (answered) return;
    fmt::print("the card failed: {}\n", helper != nullptr ? helper->problem() : "no helper");
    ++failures;
  }
  bool fit(const hal::Frame& frame, const align::SampleShape& shape, const align::SurfaceMap& mirror,
           const align::FitQuestion& question, align::CardFit& fitted) override {
    const double start_us = now_us();
    const bool done = twin.has_card() && align_twin.fit(*helper, frame, shape, mirror, question, fitted);
    check(done);
    fit_us.us.push_back(now_us() - start_us);
    fit_card_us.us.push_back(static_cast<double>(helper->stages_us()[0]));
    steps += helper->alignment().state->steps;
    return done;
  }
  bool add(const hal::RigidTransform& T, hal::TimeNs stamp_ns, bool looks_at_map, align::SurfaceMap& mirror) override {
    const double start_us = now_us();
    const bool done = twin.has_card() && (!looks_at_map || twin.send_changes()) &&
                      align_twin.add(*helper, T, stamp_ns, looks_at_map, resolution_m, mirror);
    check(done);
    add_us.us.push_back(now_us() - start_us);
    add_card_us.us.push_back(static_cast<double>(helper->stages_us()[0]));
    touched += helper->alignment().state->touched;
    return done;
  }
  void forget_surfaces() override { align_twin.forget_card(); }
  void integrate(const hal::Frame& frame, const hal::Pose& pose) {
    const auto geometry = cpu::frame_geometry(sensor, hal::to_transform(pose));
    FrameReport report;
    if (geometry) check(twin.integrate(frame, *geometry, frame.has_colour, ++frame_number, report));
  }

  float resolution_m;
  cpu::SensorGeometry sensor;
  VoxelMap map;
  cuda::Twin twin;
  cuda::AlignTwin align_twin;
  std::shared_ptr<cuda::HelperProcess> helper;
  std::uint32_t frame_number = 0;
  Times fit_us, fit_card_us, add_us, add_card_us;
  std::uint64_t steps = 0, touched = 0;
};

std::vector<align::SurfaceCell> cells_of(const align::SurfaceMap& map) {
  std::vector<align::SurfaceCell> cells;
  for (const align::SurfaceCell& cell : map.table()) {
    if (cell.key != 0) cells.push_back(cell);
  }
  std::sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
  return cells;
}

bool are_equal(const align::AlignResult& a, const align::AlignResult& b) {
  return a.outcome == b.outcome && a.T_world_camera.translation_m == b.T_world_camera.translation_m &&
         a.T_world_camera.rotation_xyzw == b.T_world_camera.rotation_xyzw && a.matched == b.matched &&
         a.residual_m == b.residual_m && a.holds_shift == b.holds_shift && a.holds_turn == b.holds_turn;
}
bool are_equal(const align::SurfaceMap& a, const align::SurfaceMap& b) {
  const auto of_a = cells_of(a);
  const auto of_b = cells_of(b);
  return of_a.size() == of_b.size() && a.refused() == b.refused() && a.unsteady_count() == b.unsteady_count() &&
         std::memcmp(of_a.data(), of_b.data(), of_a.size() * sizeof(align::SurfaceCell)) == 0;
}

void run(const test::Workload& work, bool hand_held, int seeds, float resolution_m) {
  std::vector<hal::StampedPose> poses;
  for (const auto& [frame, pose] : work.frames) poses.push_back({frame.stamp_ns, pose});
  Times all_us, cpu_us;
  std::size_t frames = 0, different = 0, corrected = 0, surfaces_different = 0;
  align::AlignOptions options;
  options.motion = hand_held ? align::Motion::free : align::Motion::planar;
  MapperConfig config;
  config.resolution_m = resolution_m;
  config.capacity = capacity_for_bytes(std::size_t{512} << 20);
  config.surface_slots = static_cast<std::uint32_t>(options.surface.slots);
  Times fit_us, fit_card_us, add_us, add_card_us;
  std::uint64_t steps = 0, touched = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto drift = hand_held ? hal::hand_held_drift(static_cast<std::uint64_t>(seed))
                                 : hal::robot_drift(static_cast<std::uint64_t>(seed));
    const std::vector<hal::StampedPose> odometry = hal::drifted(poses, drift);
    Rig rig(config, work);
    if (!rig.twin.has_card()) return;
    const align::SeenSpace space(rig.map);
    const align::SeenSpace* const looks_at = seed % 2 == 0 ? &space : nullptr;
    align::Aligner by_card(options, work.camera, &rig);
    align::Aligner by_cpu(options, work.camera);
    for (std::size_t i = 0; i < work.frames.size(); ++i) {
      const hal::Frame& frame = work.frames[i].frame;
      const double start_us = now_us();
      const align::AlignResult result = by_card.align(frame, odometry[i].T_world_camera, looks_at);
      const double half_us = now_us();
      const align::AlignResult expected = by_cpu.align(frame, odometry[i].T_world_camera, looks_at);
      const double end_us = now_us();
      if (i > 0) {  // the first one also sends all surfaces
        all_us.us.push_back(half_us - start_us);
        cpu_us.us.push_back(end_us - half_us);
      }
      ++frames;
      different += are_equal(result, expected) ? 0 : 1;
      corrected += result.outcome == align::AlignOutcome::aligned ? 1 : 0;
      rig.integrate(frame, result.T_world_camera);
    }
    surfaces_different += are_equal(by_card.surfaces(), by_cpu.surfaces()) ? 0 : 1;
    const auto append = [](Times& to, const Times& from) {
      if (!from.us.empty()) to.us.insert(to.us.end(), from.us.begin() + 1, from.us.end());
    };
    append(fit_us, rig.fit_us);
    append(fit_card_us, rig.fit_card_us);
    append(add_us, rig.add_us);
    append(add_card_us, rig.add_card_us);
    steps += rig.steps;
    touched += rig.touched;
    if (seed == seeds) fmt::print("{}, {} by {}\n", work.name, hand_held ? "free" : "planar", rig.helper->card_name());
  }
  failures += different == 0 && surfaces_different == 0 ? 0 : 1;
  const auto count = static_cast<double>(std::max<std::size_t>(frames, 1));
  fmt::print("equal   {} frames, {} aligned, {} different; {} runs, surfaces different in {} {}\n", frames, corrected,
             different, seeds, surfaces_different, different == 0 && surfaces_different == 0 ? "ok" : "FAILED");
  fmt::print("time    median (p95) us: all {}, fit {} of that the card {}, add {} of that the card {}, CPU twin {}\n",
             all_us.text(), fit_us.text(), fit_card_us.text(), add_us.text(), add_card_us.text(), cpu_us.text());
  fmt::print("        {:.1f} steps and {:.0f} changed cells a frame\n", static_cast<double>(steps) / count,
             static_cast<double>(touched) / count);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  int frames = 60;
  int seeds = 2;
  float resolution_m = 0.02F;
  std::vector<std::string> logs;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--frames") frames = std::atoi(argv[i + 1]);
    if (name == "--seeds") seeds = std::atoi(argv[i + 1]);
    if (name == "--log") logs.emplace_back(argv[i + 1]);
    if (name == "--resolution") resolution_m = static_cast<float>(std::atof(argv[i + 1]));
  }
  if (frames < 2 || seeds < 1) {
    fmt::print(stderr, "gpu_align_bench: at least two frames and one seed\n");
    return 1;
  }
  run(test::simulated_drive("furnished_room", frames, 60.0 / frames), false, seeds, resolution_m);
  for (const std::string& log : logs) {
    const test::Workload work = test::recorded(log, static_cast<std::size_t>(frames));
    if (work.frames.empty()) {
      fmt::print(stderr, "gpu_align_bench: no frames in {}\n", log);
      return 1;
    }
    run(work, true, seeds, resolution_m);
  }
  fmt::print("{} failures\n", failures);
  return failures == 0 ? 0 : 1;
}
