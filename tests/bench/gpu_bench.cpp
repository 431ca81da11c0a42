// SPDX-License-Identifier: Apache-2.0
// What a card does, on a machine that has one: the same map as the CPU twin after every frame, in how much time, and
// what a killed helper costs. `scripts/gpu-test` makes a bundle of it.
//   gpu_bench [--log FOLDER] [--frames N] [--resolution METRES]... [--integrator NAME]... [--mode static|dynamic]...
//             [--what equal|time|growth|inspect|repeat|kill]... [--times N] [--processors N]... [--patience SECONDS]
// equal: hashes of both maps after each frame. time: medians over the frames, first pass and revisit, on N of the
// card's multiprocessors (0: all). growth: frames in a map of more than a hundred million voxels. inspect: few frames,
// for compute-sanitizer. repeat: N runs, each with a new helper. kill: N kills of the helper at random moments; the map
// must be that of the undisturbed run. --patience: how long a frame may take before the helper is taken for hung.
#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "hal/clock.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/mapper.hpp"
#include "tests/bench/gpu_growth.hpp"
#include "tests/bench/gpu_rig.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;
using namespace g3d::mapper;
using bench::failures;
using bench::median;
using bench::Rig;
using bench::title;

namespace {

double now_us() { return static_cast<double>(hal::RealClock().now()) * 1e-3; }

MapperConfig on(Backend backend, MapperConfig config) {
  config.backend = backend;
  return config;
}

bool has_card(const Mapper& mapper) {
  if (std::string(mapper.backend_name()) == "cuda") return true;
  fmt::print("no card: {}\n", mapper.card().problem);
  ++failures;
  return false;
}

void check_equal(const MapperConfig& config, const test::Workload& work) {
  Mapper cpu_twin(on(Backend::cpu, config), work.camera);
  Mapper card_twin(on(Backend::cuda, config), work.camera);
  if (!has_card(card_twin)) return;
  std::size_t different = 0;
  for (const auto& [frame, pose] : work.frames) {
    const FrameReport a = cpu_twin.integrate(frame, pose);
    const FrameReport b = card_twin.integrate(frame, pose);
    const bool equal = map_hash(cpu_twin.map()) == map_hash(card_twin.map()) && a.refused_blocks == b.refused_blocks &&
                       a.valid_pixels == b.valid_pixels && a.hit_blocks == b.hit_blocks;
    different += equal ? 0 : 1;
  }
  const CardReport card = card_twin.card();
  const bool good = different == 0 && card.frames_on_card == work.frames.size();
  failures += good ? 0 : 1;
  fmt::print("equal   {}: {} of {} frames by {}, {} different, hash {:.16} {}\n", title(config, work),
             card.frames_on_card, work.frames.size(), card.name, different, map_hash(card_twin.map()),
             good ? "ok" : "FAILED " + card.problem);
  std::fflush(stdout);
}

void measure(const MapperConfig& config, const test::Workload& work, std::uint32_t processors) {
  Rig rig(config, work.camera, processors);
  if (!rig.twin.has_card()) {
    ++failures;
    return;
  }
  const std::string name = title(config, work) + fmt::format(", {} multiprocessors", rig.helper->processors());
  constexpr std::array kPasses{"first", "again", "again"};
  for (std::size_t pass = 0; pass < kPasses.size(); ++pass) {
    const bool by_stages = pass == 2;
    std::vector<double> changed;
    std::array<std::vector<double>, cuda::kStages> stage_us;
    rig.helper->set_frame_command(by_stages ? cuda::HelperCommand::run_stages_timed
                                            : cuda::HelperCommand::run_frame_timed);
    for (const auto& [frame, pose] : work.frames) {
      (void)rig.integrate(frame, pose);
      changed.push_back(static_cast<double>(rig.twin.changed_slots().size()));
      for (std::size_t s = 0; s < stage_us.size(); ++s) {
        stage_us[s].push_back(static_cast<double>(rig.helper->stages_us()[s]));
      }
    }
    if (by_stages) {
      fmt::print(
          "stages  {}: copy {:.1f} read {:.1f} walk {:.1f} find {:.1f} update {:.1f} classes {:.1f} export {:.1f} us\n",
          name, median(stage_us[0]), median(stage_us[1]), median(stage_us[2]), median(stage_us[3]),
          median(stage_us[4]) + median(stage_us[5]), median(stage_us[6]), median(stage_us[7]));
    } else {
      fmt::print("time    {}: {} pass, card {:.1f} us, classes back {:.1f} us, blocks back {:.1f} us, {:.0f} of them\n",
                 name, kPasses[pass], median(stage_us[0]), median(stage_us[1]), median(stage_us[2]), median(changed));
    }
  }
  if (processors != 0) return;
  // What a robot sees: from the frame to the classes in its memory, and on to the updated mirror; twice; and the CPU
  // twin on one core.
  MapperConfig one_thread = on(Backend::cpu, config);
  one_thread.threads = 1;
  Mapper with_card(on(Backend::cuda, config), work.camera);
  Mapper alone(one_thread, work.camera);
  for (const char* pass : {"first", "again"}) {
    std::vector<double> classes_us;
    std::vector<double> card_us;
    std::vector<double> cpu_us;
    for (const auto& [frame, pose] : work.frames) {
      const double start_us = now_us();
      if (with_card.begin_frame(frame, pose)) classes_us.push_back(now_us() - start_us);
      (void)with_card.finish_frame();
      const double half_us = now_us();
      (void)alone.integrate(frame, pose);
      card_us.push_back(half_us - start_us);
      cpu_us.push_back(now_us() - half_us);
    }
    fmt::print("whole   {}: {} pass, frame to classes {:.0f} us, to mirror {:.0f} us, CPU twin {:.0f} us\n",
               title(config, work), pass, median(classes_us), median(card_us), median(cpu_us));
  }
  const MapCounts counts = rig.map.counts();
  fmt::print("memory  {}: {} known voxels, {:.2f} bytes each in the mirror, card {} MB reserved\n", title(config, work),
             counts.known(), static_cast<double>(rig.map.memory().used_bytes) / static_cast<double>(counts.known()),
             rig.helper->card_bytes() >> 20);
  std::fflush(stdout);
}

/// For a tool that looks over the helper's shoulder, however slow it makes it: all kernels, in few frames.
void inspect(const MapperConfig& config, const test::Workload& work) {
  Rig rig(config, work.camera);
  if (!rig.twin.has_card()) {
    ++failures;
    return;
  }
  Mapper cpu_twin(on(Backend::cpu, config), work.camera);
  std::size_t different = 0;
  for (const auto& [frame, pose] : work.frames) {
    (void)rig.integrate(frame, pose);
    (void)cpu_twin.integrate(frame, pose);
    different += map_hash(rig.map) == map_hash(cpu_twin.map()) ? 0 : 1;
    // A change of the host's own, so that blocks are taken to the card.
    const BlockKey key = cpu_twin.map().sorted_keys().at(0);
    different += rig.map.erase_block(key) && cpu_twin.map().erase_block(key) ? 0 : 1;
  }
  const bool ended = rig.helper->end(bench::rig_options.patience_ns);
  const bool good = different == 0 && ended;
  failures += good ? 0 : 1;
  fmt::print("inspect {}: {} different, helper {} {}\n", title(config, work), different,
             ended ? "ended by itself" : "did not end", good ? "ok" : "FAILED");
  std::fflush(stdout);
}

std::string hash_of_run(const MapperConfig& config, const test::Workload& work) {
  Mapper mapper(config, work.camera);
  for (const auto& [frame, pose] : work.frames) (void)mapper.integrate(frame, pose);
  if (config.backend == Backend::cuda && mapper.card().frames_on_card != work.frames.size()) return "lost";
  return map_hash(mapper.map());
}

void repeat(const MapperConfig& config, const test::Workload& work, int times) {
  const std::string expected = hash_of_run(on(Backend::cpu, config), work);
  int different = 0;
  for (int i = 0; i < times; ++i) different += hash_of_run(on(Backend::cuda, config), work) == expected ? 0 : 1;
  failures += different == 0 ? 0 : 1;
  fmt::print("repeat  {}: {} runs, {} different {}\n", title(config, work), times, different,
             different == 0 ? "ok" : "FAILED");
  std::fflush(stdout);
}

void kill_often(const MapperConfig& config, const test::Workload& work, int times) {
  tests::Random random(7);
  int kills = 0;
  int different = 0;
  std::uint64_t on_card = 0;
  std::uint64_t on_cpu = 0;
  double longest_us = 0.0;
  const std::string expected = hash_of_run(on(Backend::cpu, config), work);
  while (kills < times) {
    Mapper mapper(on(Backend::cuda, config), work.camera);
    if (!has_card(mapper)) return;
    std::atomic<int> victim{mapper.card_process()};
    std::atomic<bool> done{false};
    std::atomic<int> killed{0};
    std::thread killer([&] {
      while (!done.load()) {
        std::this_thread::sleep_for(std::chrono::microseconds(500 + random.below(60'000)));
        const int pid = victim.exchange(-1);
        if (pid > 0 && kill(pid, SIGKILL) == 0) ++killed;
      }
    });
    for (const auto& [frame, pose] : work.frames) {
      const double start_us = now_us();
      (void)mapper.integrate(frame, pose);
      longest_us = std::max(longest_us, now_us() - start_us);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (std::string(mapper.backend_name()) == "cuda" && victim.load() < 0) victim.store(mapper.card_process());
    }
    done.store(true);
    killer.join();
    kills += killed.load();
    different += map_hash(mapper.map()) == expected ? 0 : 1;
    on_card += mapper.card().frames_on_card;
    on_cpu += mapper.card().frames_on_cpu;
  }
  failures += different == 0 ? 0 : 1;
  fmt::print(
      "kill    {}: {} kills, {} maps different, {} frames by the card, {} by the CPU, longest frame {:.0f} us {}\n",
      title(config, work), kills, different, on_card, on_cpu, longest_us, different == 0 ? "ok" : "FAILED");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  int frames = 60;
  int times = 100;
  double step_s = 0.0;
  double patience_s = 0.0;
  std::string log;
  std::vector<float> resolutions_m;
  std::vector<IntegratorKind> kinds;
  std::vector<MapMode> modes;
  std::vector<std::string> what;
  std::vector<std::uint32_t> processors;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    const std::string value = argv[i + 1];
    if (name == "--log") log = value;
    if (name == "--frames") frames = std::atoi(value.c_str());
    if (name == "--times") times = std::atoi(value.c_str());
    if (name == "--patience") patience_s = std::atof(value.c_str());
    if (name == "--kernels") {
      std::ifstream file(value);
      bench::rig_options.kernels.assign(std::istreambuf_iterator<char>(file), {});
    }
    if (name == "--helper") {
      std::ifstream file(value, std::ios::binary);
      bench::rig_options.helper.assign(std::istreambuf_iterator<char>(file), {});
    }
    if (name == "--warps") bench::rig_options.update_warps = static_cast<std::uint32_t>(std::atoi(value.c_str()));
    if (name == "--processors") processors.push_back(static_cast<std::uint32_t>(std::atoi(value.c_str())));
    if (name == "--step") step_s = std::atof(value.c_str());
    if (name == "--what") what.push_back(value);
    if (name == "--resolution") resolutions_m.push_back(static_cast<float>(std::atof(value.c_str())));
    if (name == "--integrator") kinds.push_back(integrator_from_string(value).value());
    if (name == "--mode") modes.push_back(mode_from_string(value).value());
  }
  if (resolutions_m.empty()) resolutions_m = {0.05F, 0.02F, 0.01F};
  if (kinds.empty()) kinds = {IntegratorKind::projective};
  if (modes.empty()) modes = {MapMode::dynamic_mode};
  if (patience_s > 0.0) bench::rig_options.patience_ns = static_cast<hal::TimeNs>(patience_s * 1e9);
  if (processors.empty()) processors = {0};
  if (what.empty()) what = {"equal", "time"};
  const test::Workload work =
      log.empty() ? test::simulated_drive("furnished_room", frames, step_s > 0.0 ? step_s : 60.0 / frames)
                  : test::recorded(log, static_cast<std::size_t>(frames));
  if (work.frames.empty()) {
    fmt::print(stderr, "gpu_bench: no frames\n");
    return 1;
  }
  for (const float resolution_m : resolutions_m) {
    for (const IntegratorKind kind : kinds) {
      for (const MapMode mode : modes) {
        MapperConfig config;
        config.resolution_m = resolution_m;
        config.integrator = kind;
        config.mode = mode;
        if (patience_s > 0.0) config.card_patience_ns = bench::rig_options.patience_ns;
        config.threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 8U));
        config.capacity = capacity_for_bytes(std::size_t{resolution_m < 0.008F ? 6144U : 1024U} << 20);
        for (const std::string& one : what) {
          if (one == "equal") check_equal(config, work);
          for (const std::uint32_t n : processors) {
            if (one == "time") measure(config, work, n);
          }
          if (one == "inspect") inspect(config, work);
          if (one == "growth") bench::measure_growth(config, work);
          if (one == "repeat") repeat(config, work, times);
          if (one == "kill") kill_often(config, work, times);
        }
      }
    }
  }
  fmt::print("{} failures\n", failures);
  return failures == 0 ? 0 : 1;
}
