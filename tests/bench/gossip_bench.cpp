// SPDX-License-Identifier: Apache-2.0
// What sharing a map costs on the air and how long it takes, with robots that publish blocks of chance over a simulated
// radio. Times are simulated, so the machine does not count.
//   gossip_bench [--payload BYTES] [--seeds N] [--only bytes|change|partition|rest|scaling] [--most-robots N]
//                [--plot FILE.png]   what grows with the number of robots, as a picture too
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "hal/image/png_writer.hpp"
#include "nav/canvas.hpp"
#include "tests/support/gossip_fleet.hpp"

using namespace g3d;
using tests::FleetOptions;
using tests::GossipFleet;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;
std::size_t payload_bytes = 60;
std::uint64_t seeds = 10;

double seconds(hal::TimeNs ns) { return static_cast<double>(ns) * 1e-9; }

FleetOptions options_for(std::uint32_t robots, double loss, std::uint64_t seed) {
  FleetOptions options;
  options.robots = robots;
  options.radio.loss = loss;
  options.radio.seed = seed;
  options.store = {robots + 4, 1U << 15, std::size_t{8} << 20};
  options.payload_bytes = payload_bytes;
  return options;
}

std::string spread(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return fmt::format("{:.3f} / {:.3f} / {:.3f}", values.front(), values[values.size() / 2], values.back());
}

/// One robot publishes in rounds, everybody is to have it all: bytes on the air per byte of content and receiver, less
/// 64 per robot and round.
void bytes_per_content(std::uint32_t robots, double loss) {
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    GossipFleet fleet(options_for(robots, loss, seed));
    fleet.run(3 * kSecond_ns);
    const std::uint64_t before = fleet.sent_bytes();
    const hal::TimeNs start = fleet.now_ns();
    std::size_t content = 0;
    for (int round = 0; round < 30; ++round) {
      content += fleet.publish_scan(0, 300);
      fleet.run(kSecond_ns);
    }
    if (!fleet.run_until_equal(60 * kSecond_ns)) fmt::print("  seed {}: never equal\n", seed);
    const double rounds = seconds(fleet.now_ns() - start) / 0.5;  // beacons
    const double free = 64.0 * robots * rounds;
    ratios.push_back((static_cast<double>(fleet.sent_bytes() - before) - free) /
                     (static_cast<double>(content) * (robots - 1)));
  }
  fmt::print("{} robots, {:.0f} % lost: {} bytes per byte of content and receiver (min/median/max)\n", robots,
             100 * loss, spread(ratios));
}

void time_of_a_change(std::uint32_t robots, double loss) {
  std::vector<double> times;
  GossipFleet fleet(options_for(robots, loss, 5));
  fleet.run(5 * kSecond_ns);
  for (std::uint64_t i = 0; i < 100 * seeds; ++i) {
    fleet.run(static_cast<hal::TimeNs>(fleet.random().bits() % 1000) * 1'000'000);
    const hal::TimeNs start = fleet.now_ns();
    (void)fleet.publish_scan(static_cast<std::uint32_t>(i % robots), 5);
    if (!fleet.run_until_equal(60 * kSecond_ns)) fmt::print("  never equal\n");
    times.push_back(seconds(fleet.now_ns() - start));
  }
  std::sort(times.begin(), times.end());
  fmt::print(
      "{} robots, {:.0f} % lost: a change is everywhere after {:.2f} s (median), {:.2f} (p99), {:.2f} (most) of {}\n",
      robots, 100 * loss, times[times.size() / 2], times[times.size() * 99 / 100], times.back(), times.size());
}

void after_a_partition() {
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    GossipFleet fleet(options_for(2, 0.0, seed));
    fleet.run(5 * kSecond_ns);
    fleet.set_group(0, 1);
    std::size_t content = 0;
    for (int i = 0; i < 60; ++i) {
      content += fleet.publish_scan(0, 10000 / 60 + 1);
      fleet.run(kSecond_ns);
    }
    fleet.run(static_cast<hal::TimeNs>(fleet.random().bits() % 1000) * 1'000'000);
    fleet.join_all();
    const hal::TimeNs start = fleet.now_ns();
    if (!fleet.run_until_equal(600 * kSecond_ns)) fmt::print("  never equal\n");
    ratios.push_back(seconds(fleet.now_ns() - start) / (static_cast<double>(content) / 250'000.0));
  }
  fmt::print("after 60 s apart, 10,000 blocks of {} bytes, 2 Mbit/s: {} times what the bytes need\n", payload_bytes,
             spread(ratios));
}

void idle(std::uint32_t robots) {
  GossipFleet fleet(options_for(robots, 0.0, 3));
  (void)fleet.publish_scan(0, 100);
  fleet.run(10 * kSecond_ns);
  const std::uint64_t before = fleet.sent_bytes();
  fleet.run(60 * kSecond_ns);
  fmt::print("{} robots at rest: {:.0f} bytes/s each\n", robots,
             static_cast<double>(fleet.sent_bytes() - before) / 60.0 / robots);
}

double cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}
double resident_mb() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  file >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

struct Scale {
  std::uint32_t robots = 0;
  double sent_kBps = 0.0;     ///< each
  double content_kBps = 0.0;  ///< each; of what it publishes
  double equal_s = 0.0;       ///< after the last change
  bool is_equal = false;
};

/// Everybody explores: 100 blocks a second each, for ten seconds.
Scale many(std::uint32_t robots) {
  FleetOptions options = options_for(robots, 0.05, 3);
  options.store = {robots + 1, 1U << 17, std::size_t{32} << 20};
  const double mb_before = resident_mb();
  const double cpu_before_s = cpu_s();
  GossipFleet fleet(options);
  fleet.run(5 * kSecond_ns);
  using Kinds = std::array<std::uint64_t, net::kMessageKinds>;
  const auto kinds = [&] {
    Kinds bytes{};
    for (std::uint32_t i = 0; i < robots; ++i) {
      for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] += fleet.gossip(i).counts().sent_bytes[k];
    }
    return bytes;
  };
  const Kinds before = kinds();
  std::size_t content = 0;
  for (int round = 0; round < 20; ++round) {
    for (std::uint32_t i = 0; i < robots; ++i) content += fleet.publish_scan(i, 50);
    fleet.run(kSecond_ns / 2);
  }
  const hal::TimeNs start = fleet.now_ns();
  const Kinds after = kinds();
  Scale scale{robots, 0.0, static_cast<double>(content) / 1e4 / robots, 0.0, fleet.run_until_equal(60 * kSecond_ns)};
  scale.equal_s = seconds(fleet.now_ns() - start);
  const auto kBps = [&](net::MessageKind kind) {
    const auto k = static_cast<std::size_t>(kind);
    return static_cast<double>(after[k] - before[k]) / 1e4 / robots;
  };
  for (std::size_t k = 0; k < before.size(); ++k) scale.sent_kBps += kBps(static_cast<net::MessageKind>(k));
  fmt::print(
      "{} robots exploring: content {:.1f}, sent {:.1f} kB/s each (news {:.1f}, data {:.1f}, answers {:.1f}, beacons "
      "and vectors {:.1f}), {} {:.2f} s after the last change, {:.1f} ms of CPU a second and {:.1f} MB each\n",
      robots, scale.content_kBps, scale.sent_kBps, kBps(net::MessageKind::news), kBps(net::MessageKind::data),
      kBps(net::MessageKind::want) + kBps(net::MessageKind::wants),
      kBps(net::MessageKind::beacon) + kBps(net::MessageKind::vector), scale.is_equal ? "equal" : "not equal",
      scale.equal_s, 1e3 * (cpu_s() - cpu_before_s) / robots / seconds(fleet.now_ns()),
      (resident_mb() - mb_before) / robots);
  std::fflush(stdout);
  return scale;
}

/// Two charts beside each other: what each robot sends, and how long until all are equal, against their number.
void plot(const std::vector<Scale>& scales, const std::string& path) {
  constexpr int kWidth_px = 900, kHeight_px = 420, kChart_px = 300, kTop_px = 60;
  constexpr nav::Colour kInk{40, 40, 40}, kGrid{220, 220, 220}, kSent{200, 60, 40}, kContent{60, 110, 190};
  nav::Canvas canvas({kWidth_px, kHeight_px}, {255, 255, 255});
  const auto chart = [&](int left_px, std::string_view title, double most, auto value, const nav::Colour& colour) {
    const auto x_px = [&](std::size_t i) {
      return left_px +
             static_cast<double>(i) * kChart_px / std::max<double>(1.0, static_cast<double>(scales.size() - 1));
    };
    const auto y_px = [&](double v) { return kTop_px + kChart_px * (1.0 - std::min(v, most) / most); };
    for (int k = 0; k <= 5; ++k) {
      const double v = most * k / 5;
      canvas.line({static_cast<double>(left_px), y_px(v)}, {static_cast<double>(left_px + kChart_px), y_px(v)}, 1.0,
                  kGrid);
      const std::string label = fmt::format("{:.3g}", v);
      canvas.text(left_px - 8 - nav::Canvas::text_width_px(label), static_cast<int>(y_px(v)) - 7, label, kInk);
    }
    canvas.text(left_px, 20, title, colour);
    for (std::size_t i = 0; i < scales.size(); ++i) {
      const std::string label = fmt::format("{}", scales[i].robots);
      canvas.text(static_cast<int>(x_px(i)) - nav::Canvas::text_width_px(label) / 2, kTop_px + kChart_px + 14, label,
                  kInk);
      canvas.disc({x_px(i), y_px(value(scales[i]))}, 4.0, colour);
      if (i > 0) {
        canvas.line({x_px(i - 1), y_px(value(scales[i - 1]))}, {x_px(i), y_px(value(scales[i]))}, 2.0, colour);
      }
    }
  };
  double most_kBps = 10.0, most_s = 1.0;
  for (const Scale& scale : scales) {
    most_kBps = std::max(most_kBps, 10.0 * std::ceil(scale.sent_kBps / 10.0));
    most_s = std::max(most_s, std::ceil(scale.equal_s));
  }
  chart(
      90, "kb/s sent by each", most_kBps, [](const Scale& s) { return s.sent_kBps; }, kSent);
  chart(
      90, "", most_kBps, [](const Scale& s) { return s.content_kBps; }, kContent);
  canvas.text(320, 27, "own content", kContent, 1);
  chart(
      540, "s until all are equal", most_s, [](const Scale& s) { return s.equal_s; }, kSent);
  canvas.text(kWidth_px / 2 - 30, kHeight_px - 22, "robots", kInk);
  if (const auto written = hal::write_png_rgb(path, canvas.size(), canvas.rgb()); !written.ok()) {
    fmt::print("{}\n", written.error().text);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string only, plot_path;
  std::uint32_t most_robots = 64;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--payload") == 0) payload_bytes = std::strtoul(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--seeds") == 0) seeds = std::strtoul(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--only") == 0) only = argv[i + 1];
    if (std::strcmp(argv[i], "--most-robots") == 0) {
      most_robots = static_cast<std::uint32_t>(std::strtoul(argv[i + 1], nullptr, 10));
    }
    if (std::strcmp(argv[i], "--plot") == 0) plot_path = argv[i + 1];
  }
  const auto is_on = [&](std::string_view part) { return only.empty() || only == part; };
  if (is_on("bytes")) {
    for (const double loss : {0.0, 0.2}) {
      for (const std::uint32_t robots : {2U, 4U}) bytes_per_content(robots, loss);
    }
  }
  if (is_on("change")) time_of_a_change(4, 0.3);
  if (is_on("partition")) after_a_partition();
  if (is_on("rest")) {
    for (const std::uint32_t robots : {2U, 4U, 16U, 64U}) idle(robots);
  }
  if (is_on("scaling")) {
    std::vector<Scale> scales;
    for (std::uint32_t robots = 2; robots <= most_robots; robots *= 2) scales.push_back(many(robots));
    if (!plot_path.empty()) plot(scales, plot_path);
  }
}
