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
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/sim/pose_drift.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/cuda/align_twin.hpp"
#include "tests/bench/gpu_rig.hpp"
#include "tests/support/same_alignment.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

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

/// The card's part of an aligner, with a watch.
struct WatchedFit final : align::FitCard {
  WatchedFit(const MapperConfig& config, const hal::CameraModel& camera) : rig(config, camera) {
    check(rig.twin.has_card());
  }
  void check(bool answered) {
    if (answered) return;
    fmt::print("the card failed: {}\n", rig.helper != nullptr ? rig.helper->problem() : "no helper");
    ++bench::failures;
  }
  bool fit(const hal::Frame& frame, const align::SampleShape& shape, const align::SurfaceMap& mirror,
           const align::FitQuestion& question, align::CardFit& fitted) override {
    const double start_us = now_us();
    const bool done = rig.twin.has_card() && align_twin.fit(*rig.helper, frame, shape, mirror, question, fitted);
    check(done);
    fit_us.us.push_back(now_us() - start_us);
    fit_card_us.us.push_back(static_cast<double>(rig.helper->stages_us()[0]));
    steps += rig.helper->alignment().state->steps;
    return done;
  }
  bool add(const hal::RigidTransform& T, hal::TimeNs stamp_ns, bool looks_at_map, align::SurfaceMap& mirror) override {
    const double start_us = now_us();
    const bool done = rig.twin.has_card() && (!looks_at_map || rig.twin.send_changes()) &&
                      align_twin.add(*rig.helper, T, stamp_ns, looks_at_map, rig.config.resolution_m, mirror);
    check(done);
    add_us.us.push_back(now_us() - start_us);
    add_card_us.us.push_back(static_cast<double>(rig.helper->stages_us()[0]));
    touched += rig.helper->alignment().state->touched;
    return done;
  }
  void forget_surfaces() override { align_twin.forget_card(); }

  bench::Rig rig;
  cuda::AlignTwin align_twin;
  Times fit_us, fit_card_us, add_us, add_card_us;
  std::uint64_t steps = 0, touched = 0;
};

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
    WatchedFit card(config, work.camera);
    if (!card.rig.twin.has_card()) return;
    const align::SeenSpace space(card.rig.map);
    const align::SeenSpace* const looks_at = seed % 2 == 0 ? &space : nullptr;
    align::Aligner by_card(options, work.camera, &card);
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
      different += test::are_equal(result, expected) ? 0 : 1;
      corrected += result.outcome == align::AlignOutcome::aligned ? 1 : 0;
      (void)card.rig.integrate(frame, result.T_world_camera);
    }
    surfaces_different += test::are_equal(by_card.surfaces(), by_cpu.surfaces()) ? 0 : 1;
    const auto append = [](Times& to, const Times& from) {
      if (!from.us.empty()) to.us.insert(to.us.end(), from.us.begin() + 1, from.us.end());
    };
    append(fit_us, card.fit_us);
    append(fit_card_us, card.fit_card_us);
    append(add_us, card.add_us);
    append(add_card_us, card.add_card_us);
    steps += card.steps;
    touched += card.touched;
    if (seed == seeds)
      fmt::print("{}, {} by {}\n", work.name, hand_held ? "free" : "planar", card.rig.helper->card_name());
  }
  bench::failures += different == 0 && surfaces_different == 0 ? 0 : 1;
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
  fmt::print("{} failures\n", bench::failures);
  return bench::failures == 0 ? 0 : 1;
}
