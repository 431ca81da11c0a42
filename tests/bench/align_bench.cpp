// SPDX-License-Identifier: Apache-2.0
// Odometry that drifts, against what alignment makes of it: error of the trajectory over ten seeds, sharpness of the
// map, time per frame.
//   align_bench [--frames N] [--step SECONDS] [--start SECONDS] [--seeds N] [--world NAME | --log FOLDER] [--free]
//               [--map METRES] [--offset SECONDS] [--verbose]
// --map also makes maps of that resolution with the true, the drifting and the corrected poses. --offset: the frames of
// a recording were taken so much later than their stamps say. Without --world and --log: five drives and their table.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>

#include "hal/sim/pose_drift.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/align/pose_step.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/map_sharpness.hpp"
#include "tests/support/trajectory_error.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;

namespace {

struct Options {
  int frames = 60;
  double step_s = 0.1;
  double start_s = 0.0;
  int seeds = 10;
  std::string world;
  std::string log;
  float map_resolution_m = 0.0F;
  double offset_s = 0.0;
  bool verbose = false;
  mapper::align::AlignOptions align;
};

Options read_options(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&] { return i + 1 < argc ? std::string(argv[++i]) : std::string(); };
    const auto number = [&] { return std::atof(value().c_str()); };
    if (word == "--frames") o.frames = static_cast<int>(number());
    if (word == "--step") o.step_s = number();
    if (word == "--start") o.start_s = number();
    if (word == "--seeds") o.seeds = static_cast<int>(number());
    if (word == "--world") o.world = value();
    if (word == "--log") o.log = value();
    if (word == "--free") o.align.motion = mapper::align::Motion::free;
    if (word == "--map") o.map_resolution_m = static_cast<float>(number());
    if (word == "--offset") o.offset_s = number();
    if (word == "--verbose") o.verbose = true;
    // What the defaults were chosen by.
    if (word == "--weight") o.align.data_weight = number();
    if (word == "--kernel") o.align.kernel_m = static_cast<float>(number());
    if (word == "--cell") o.align.surface.rule.cell_m = static_cast<float>(number());
    if (word == "--spacing") o.align.samples.spacing_m = static_cast<float>(number());
    if (word == "--far") o.align.samples.far_m = static_cast<float>(number());
    if (word == "--least") o.align.surface.rule.least_sample_weight = static_cast<float>(number());
    if (word == "--age") o.align.least_age_ns = static_cast<hal::TimeNs>(1e9 * number());
    if (word == "--matched") o.align.least_matched = number();
  }
  return o;
}

using Poses = std::vector<hal::StampedPose>;

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

void row(const char* name, const std::vector<double>& v) {
  if (v.empty()) return;
  fmt::print("  {:30} {:8.2f} {:8.2f} {:8.2f} {:8.2f}\n", name, quantile(v, 0.0), quantile(v, 0.5), quantile(v, 0.95),
             quantile(v, 1.0));
}

/// Where the camera was `offset_s` after each stamp: towards the neighbour on that side, else away from the other one.
Poses shifted(const Poses& truth, double offset_s) {
  Poses result = truth;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto is_near = [&](std::size_t j) {
      return j < truth.size() && std::abs(truth[j].stamp_ns - truth[i].stamp_ns) < 100'000'000;
    };
    const std::size_t wanted = offset_s < 0 ? i - 1 : i + 1;
    const std::size_t j = is_near(wanted) ? wanted : 2 * i - wanted;
    if (!is_near(j)) continue;
    const double fraction = offset_s / (static_cast<double>(truth[j].stamp_ns - truth[i].stamp_ns) / 1e9);
    hal::Pose other = truth[j].T_world_camera;
    if (fraction < 0) {
      other = hal::compose(truth[i].T_world_camera, hal::compose(hal::inverse(other), truth[i].T_world_camera));
    }
    result[i].T_world_camera = hal::interpolate(truth[i].T_world_camera, other, std::min(std::abs(fraction), 1.0));
  }
  return result;
}

std::unique_ptr<mapper::Mapper> map_of(const test::Workload& work, const Poses& poses, float resolution_m) {
  mapper::MapperConfig config;
  config.resolution_m = resolution_m;
  config.with_colour = false;
  config.capacity = mapper::capacity_for_bytes(std::size_t{512} << 20);
  config.threads = 2;
  auto made = std::make_unique<mapper::Mapper>(config, work.camera);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    (void)made->integrate(work.frames[i].frame, poses[i].T_world_camera);
  }
  return made;
}

void tell(std::size_t i, const mapper::align::AlignResult& result, const hal::Pose& truth) {
  const mapper::align::Vector6 error = mapper::align::difference(truth, result.T_world_camera);
  fmt::print(
      "{:3} {:16} matched {:.2f} shift {:5.1f} mm turn {:5.2f} mrad surprise {:4.1f} held {:d}{:d} error {:5.1f} mm "
      "{:5.2f} mrad\n",
      i, to_string(result.outcome), result.matched, 1e3 * mapper::align::shift_of(result.correction),
      1e3 * mapper::align::turn_of(result.correction), result.surprise, result.holds_shift, result.holds_turn,
      1e3 * mapper::align::shift_of(error), 1e3 * mapper::align::turn_of(error));
}

void run(const test::Workload& work, const Options& o) {
  Poses truth;
  for (const test::PosedImage& image : work.frames) truth.push_back({image.frame.stamp_ns, image.T_world_camera});
  if (o.offset_s != 0.0) truth = shifted(truth, o.offset_s);
  const bool hand_held = o.align.motion == mapper::align::Motion::free;
  const auto true_map = o.map_resolution_m > 0.0F ? map_of(work, truth, o.map_resolution_m) : nullptr;
  std::vector<double> before_mm, after_mm, ratio, before_deg, after_deg, before_rpe, after_rpe, ms;
  std::vector<double> sharp_before[2], sharp_after[2];
  for (int s = 1; s <= o.seeds; ++s) {
    const auto seed = static_cast<std::uint64_t>(s);
    const Poses odometry = hal::drifted(truth, hand_held ? hal::hand_held_drift(seed) : hal::robot_drift(seed));
    mapper::align::Aligner aligner(o.align, work.camera);
    Poses aligned;
    for (std::size_t i = 0; i < work.frames.size(); ++i) {
      const auto start = std::chrono::steady_clock::now();
      const auto result = aligner.align(work.frames[i].frame, odometry[i].T_world_camera);
      ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
      aligned.push_back({truth[i].stamp_ns, result.T_world_camera});
      if (o.verbose && s == 1) tell(i, result, truth[i].T_world_camera);
    }
    const test::TrajectoryError a = test::trajectory_error(truth, odometry);
    const test::TrajectoryError b = test::trajectory_error(truth, aligned);
    before_mm.push_back(1e3 * a.ate_m);
    after_mm.push_back(1e3 * b.ate_m);
    ratio.push_back(b.ate_m / a.ate_m);
    before_deg.push_back(a.turn_rms_deg);
    after_deg.push_back(b.turn_rms_deg);
    before_rpe.push_back(a.rpe_turn_deg);
    after_rpe.push_back(b.rpe_turn_deg);
    if (true_map == nullptr) continue;
    const auto compare = [&](const Poses& poses, std::vector<double>* sharp) {
      const auto map = map_of(work, poses, o.map_resolution_m);
      sharp[0].push_back(100.0 * test::share_near(map->map(), true_map->map()));
      sharp[1].push_back(100.0 * test::share_near(true_map->map(), map->map()));
    };
    compare(odometry, sharp_before);
    compare(aligned, sharp_after);
  }
  fmt::print("{} from {:g} s: {} frames, {:.1f} s, {} seeds: min median p95 max\n", work.name, o.start_s,
             work.frames.size(), static_cast<double>(truth.back().stamp_ns - truth.front().stamp_ns) / 1e9, o.seeds);
  row("odometry ATE, mm", before_mm);
  row("aligned ATE, mm", after_mm);
  row("aligned / odometry", ratio);
  row("odometry turn rms, degrees", before_deg);
  row("aligned turn rms, degrees", after_deg);
  row("odometry RPE 1 s, degrees", before_rpe);
  row("aligned RPE 1 s, degrees", after_rpe);
  row("drifting map precision, %", sharp_before[0]);
  row("drifting map recall, %", sharp_before[1]);
  row("corrected map precision, %", sharp_after[0]);
  row("corrected map recall, %", sharp_after[1]);
  row("time per frame, ms", ms);
}

}  // namespace

int main(int argc, char** argv) {
  Options o = read_options(argc, argv);
  const bool is_table = o.world.empty() && o.log.empty();
  if (o.world.empty()) o.world = "furnished_room";
  do {
    const test::Workload work = o.log.empty() ? test::simulated_drive(o.world, o.frames, o.step_s, o.start_s)
                                              : test::recorded(o.log, static_cast<std::size_t>(o.frames));
    if (work.frames.empty()) {
      fmt::print(stderr, "align_bench: no frames in {}\n", o.log.empty() ? o.world : o.log);
      return 1;
    }
    run(work, o);
    o.start_s += 10.0;
  } while (is_table && o.start_s < 50.0);
  return 0;
}
