// SPDX-License-Identifier: Apache-2.0
// What it costs robots to agree on who goes where, and how long it takes, without any map: they gossip over a simulated
// radio and drive to places of chance. Times are simulated, so the machine does not count.
//   team_bench [--runs N]
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "tests/support/team_fleet.hpp"

using namespace g3d;
using tests::TeamFleet;
using tests::TeamFleetOptions;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;
std::uint64_t runs = 200;

TeamFleetOptions team_of(std::uint32_t robots, double loss, std::uint64_t seed, int places) {
  TeamFleetOptions options;
  options.fleet.robots = robots;
  options.fleet.radio.loss = loss;
  options.fleet.radio.seed = seed;
  options.fleet.store = {robots + 4, 1U << 12, std::size_t{1} << 20};
  options.places = places;
  return options;
}

std::string spread(std::vector<hal::TimeNs> times) {
  std::sort(times.begin(), times.end());
  const auto s = [&](std::size_t i) { return static_cast<double>(times[i]) * 1e-9; };
  return fmt::format("{:.2f} s (median), {:.2f} (p99), {:.2f} (most) of {}", s(times.size() / 2),
                     s(times.size() * 99 / 100), s(times.size() - 1), times.size());
}

void traffic(std::uint32_t robots) {
  TeamFleet rest(team_of(robots, 0.0, 1, 0));
  rest.run(15 * kSecond_ns);
  std::uint64_t before = rest.fleet().sent_bytes();
  rest.run(20 * kSecond_ns);
  const double rest_Bps = static_cast<double>(rest.fleet().sent_bytes() - before) / 20.0 / robots;
  TeamFleetOptions options = team_of(robots, 0.0, 1, 40 * static_cast<int>(robots));
  options.extent_m = 60.0;
  TeamFleet drives(options);
  drives.run(15 * kSecond_ns);
  before = drives.fleet().sent_bytes();
  drives.run(20 * kSecond_ns);
  const double drives_Bps = static_cast<double>(drives.fleet().sent_bytes() - before) / 20.0 / robots;
  fmt::print("{} robots: {:.0f} bytes/s each at rest, {:.0f} while all drive\n", robots, rest_Bps, drives_Bps);
}

/// How long a claim of a robot that dies is respected by anybody.
void claims_of_the_dead(double loss) {
  std::vector<hal::TimeNs> times;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    TeamFleet team(team_of(4, loss, seed, 40));
    hal::SeededRandom random(seed);
    team.run(5 * kSecond_ns + static_cast<hal::TimeNs>(random.bits() % 5000) * 1'000'000);
    const auto dead = static_cast<std::uint32_t>(random.bits() % 4);
    const hal::TimeNs died_ns = team.fleet().now_ns();
    team.kill(dead);
    hal::TimeNs last_ns = died_ns;
    while (team.fleet().now_ns() < died_ns + 10 * kSecond_ns) {
      team.step();
      for (std::uint32_t other = 0; other < 4; ++other) {
        if (team.is_alive(other) && team.respects(other, dead + 1)) last_ns = team.fleet().now_ns();
      }
    }
    times.push_back(last_ns - died_ns);
  }
  fmt::print("{:.0f} % lost: what a dead robot claimed is free after {}\n", 100 * loss, spread(times));
}

hal::TimeNs until_settled(TeamFleet& team) {
  const hal::TimeNs begin_ns = team.fleet().now_ns();
  hal::TimeNs last_ns = begin_ns;
  while (team.fleet().now_ns() < begin_ns + 15 * kSecond_ns) {
    team.step();
    if (!team.is_settled()) last_ns = team.fleet().now_ns();
  }
  return last_ns - begin_ns;
}

void leaders(double loss) {
  std::vector<hal::TimeNs> start, death, cut, healed;
  for (std::uint64_t seed = 1; seed <= runs / 2; ++seed) {
    TeamFleet team(team_of(4, loss, seed, 0));
    start.push_back(until_settled(team));
    for (const std::uint32_t i : {0U, 1U}) team.fleet().set_group(i, 1);
    cut.push_back(until_settled(team));
    team.fleet().join_all();
    healed.push_back(until_settled(team));
    team.kill(static_cast<std::uint32_t>(team.talk(3).cluster().office().leader - 1));
    death.push_back(until_settled(team));
  }
  fmt::print("{:.0f} % lost: all of four follow one leader after\n", 100 * loss);
  fmt::print("  their start       {}\n  the leader's death {}\n", spread(start), spread(death));
  fmt::print("  a cut (each half)  {}\n  its end            {}\n", spread(cut), spread(healed));
}

void peace(double loss, std::uint32_t robots) {
  TeamFleet team(team_of(robots, loss, 5, 0));
  team.run(15 * kSecond_ns);
  std::uint64_t before = 0, after = 0;
  for (std::uint32_t i = 0; i < robots; ++i) before += team.talk(i).cluster().counts().changed_leaders;
  team.run(3600 * kSecond_ns);
  for (std::uint32_t i = 0; i < robots; ++i) after += team.talk(i).cluster().counts().changed_leaders;
  fmt::print("{} robots, {:.0f} % lost, an hour in peace: {} changes of whom one follows\n", robots, 100 * loss,
             after - before);
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--runs") == 0) runs = std::strtoul(argv[i + 1], nullptr, 10);
  }
  for (const std::uint32_t robots : {2U, 4U, 8U, 16U}) traffic(robots);
  for (const double loss : {0.0, 0.3}) claims_of_the_dead(loss);
  for (const double loss : {0.0, 0.3}) leaders(loss);
  for (const std::uint32_t robots : {2U, 4U}) peace(0.3, robots);
}
