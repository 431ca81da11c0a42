// SPDX-License-Identifier: Apache-2.0
// `g3dmap sim --robots N` with more than one: robots that explore one simulated building together, in lockstep, and
// share their maps over a simulated radio.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "hal/clock.hpp"
#include "hal/sim/disk_faults.hpp"
#include "hal/sim/sim_building.hpp"
#include "main_save.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "main_team_run.hpp"
#include "mapper/block_source.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/report.hpp"
#include "mapper/summary.hpp"
#include "mapper/version.hpp"
#include "nav/exploration_report.hpp"
#include "nav/outputs.hpp"
#include "net/team_report.hpp"

namespace g3d {
namespace {

/// The map of all layers that a robot holds, made from the start.
std::unique_ptr<net::MergedMap> whole_map(Team::Member& member) {
  net::MergedOptions options;
  const mapper::VoxelMap& own = member.robot.mapper().map();
  options.grid = own.grid();
  options.merged = own.capacity();
  options.submap = own.capacity();
  options.most_submaps = member.sharing.store().layer_count() * kTeamSubmaps;
  auto merged = std::make_unique<net::MergedMap>(options);
  merged->take_all(member.sharing.store());
  return merged;
}

/// What is saved of a robot wherever it goes; the map, the picture and what is drawn into it are still to be said.
RunFiles member_files(const Team::Member& member, const ExploreSetup& setup, const SimOptions& options,
                      const std::string& folder) {
  RunFiles files;
  files.folder = folder;
  files.patience_s = options.mapping.patience_s;
  files.way = member.way;
  files.options.band = {static_cast<float>(setup.board.ground_low_m), static_cast<float>(setup.board.ground_high_m)};
  files.options.meta.steps = setup.configs[member.number].mapper.steps;
  files.is_given_up = [was = is_stop_requested()] { return !was && is_stop_requested(); };
  return files;
}

struct MemberEnd {
  std::string json;
  nav::Outputs outputs;
};

/// The robot's own folder: its own map, its way and its report.
MemberEnd save_member(Team& team, std::size_t i, const ExploreSetup& setup, const SimOptions& options,
                      const std::string& merged_hash, const std::string& command_line) {
  Team::Member& member = team.member(i);
  const nav::ExplorationReport explored = explored_by(member.robot, team.building().record(i), team.driving_ns());
  const std::vector<hal::Pose> poses = poses_of(member.way);
  RunFiles files = member_files(member, setup, options, fmt::format("{}/robot{}", options.mapping.out_dir, i + 1));
  files.map = &member.robot.mapper().map();
  files.options.trajectory = poses;
  files.draw = [&](const std::string& path) {
    return write_picture(explored, member.robot.navigator(), poses, fmt::format("{}, robot {}", setup.place, i + 1),
                         path);
  };
  MemberEnd end;
  if (const auto folder = open_folder(files.folder); !folder) {
    end.outputs.failures.push_back(folder.error());
    return end;
  }
  end.outputs = save_run(files);
  mapper::RunReport report = report_of(member.robot, options, setup.board, end.outputs, command_line);
  report.write_more = [&](mapper::JsonWriter& json) {
    json.member("id", i + 1).member("merged_hash", merged_hash);
    nav::write_exploration(json, explored);
    member.place_error.write(json);
    net::write_sharing(json, member.sharing, static_cast<double>(team.driving_ns() + team.settle_ns()) * 1e-9);
    net::write_in_team(json, member.talk);
    json.member("robot_contacts", team.building().record(i).contacts_robots);
    if (!member.is_alive()) json.member("died_s", static_cast<double>(member.died_ns) * 1e-9);
  };
  end.json = to_json(report);
  save_report(files, end.json, end.outputs);
  return end;
}

}  // namespace

int run_team(const SimOptions& options, const std::string& command_line) {
  const MappingOptions& mapping = options.mapping;
  ExploreSetup setup;
  if (const int code = prepare_exploration(options, setup); code != kExitDone) return code;
  auto trouble = net::parse_trouble(options.cuts, options.deaths, static_cast<std::uint32_t>(options.robots));
  if (!trouble) return bad_usage(trouble.error().text);
  hal::SimBuilding building(std::move(setup.world), setup.building);
  Team team(building, setup.configs, options, std::move(trouble).value(), setup.observable, setup.rate_hz);
  for (std::size_t i = 0; i < team.size(); ++i) {
    if (const auto missing = missing_card(team.member(i).robot.mapper(), mapping)) return fail(*missing);
  }
  catch_stop_signals();
  hal::RealClock clock;
  const hal::TimeNs start_ns = clock.now();
  // As for one robot: by simulated time, and by the real one while what was mapped is saved.
  hal::TimeNs end_ns = 0;
  const auto disk_time = [&] { return team.now_ns() + (end_ns > 0 ? clock.now() - end_ns : 0); };
  hal::DiskFaults bad_disk(setup.staging.faults, disk_time);
  const hal::DiskInstead disk_instead(bad_disk);
  team.run(static_cast<hal::TimeNs>(setup.limit_s * 1e9), !mapping.quiet && isatty(STDERR_FILENO) != 0);
  end_ns = clock.now();
  const double run_s = static_cast<double>(end_ns - start_ns) / 1e9;

  std::vector<std::string> hashes;
  std::unique_ptr<net::MergedMap> merged;
  std::size_t first_alive = team.size();
  for (std::size_t i = 0; i < team.size(); ++i) {
    auto of_robot = whole_map(team.member(i));
    hashes.push_back(mapper::map_hash(of_robot->map()));
    const bool is_first = team.member(i).is_alive() && first_alive == team.size();
    if (is_first) first_alive = i;
    if (i == 0 || is_first) merged = std::move(of_robot);
  }
  if (first_alive == team.size()) first_alive = 0;
  std::vector<MemberEnd> ends;
  std::vector<hal::Error> failures;
  for (std::size_t i = 0; i < team.size(); ++i) {
    ends.push_back(save_member(team, i, setup, options, hashes[i], command_line));
    failures.insert(failures.end(), ends.back().outputs.failures.begin(), ends.back().outputs.failures.end());
  }
  // Above them the one map of all, as the first robot that lives holds it, with its own way.
  Team::Member& first = team.member(first_alive);
  const std::vector<hal::Pose> first_way = poses_of(first.way);
  RunFiles files = member_files(first, setup, options, mapping.out_dir);
  files.map = &merged->map();
  files.draw = [&](const std::string& path) {
    return write_picture(explored_by(first.robot, building.record(first_alive), team.driving_ns()),
                         first.robot.navigator(), first_way, fmt::format("{}, {} robots", setup.place, team.size()),
                         path);
  };
  nav::Outputs outputs = save_run(files);
  bool are_equal = true;
  for (std::size_t i = 0; i < team.size(); ++i) {
    if (team.member(i).is_alive()) are_equal = are_equal && hashes[i] == hashes[first_alive];
  }
  const mapper::MapCounts counts = merged->map().counts();
  mapper::JsonWriter head;
  head.begin_object().key("map").begin_object().member("resolution_m", setup.board.map_resolution_m);
  head.member("occupied", counts.occupied).member("free", counts.free).member("hash", hashes[first_alive]);
  head.member("file_bytes", outputs.map_file_bytes).end_object();
  head.key("team").begin_object().member("robots", team.size()).member("all_hold_the_same", are_equal);
  head.member("time_s", static_cast<double>(team.driving_ns()) * 1e-9);
  head.member("settle_s", static_cast<double>(team.settle_ns()) * 1e-9);
  head.member("lost_datagrams", team.radio().lost())
      .member("delivered_datagrams", team.radio().delivered())
      .end_object();
  head.end_object();
  std::string json = head.take();
  json.erase(json.rfind('}'));
  json += ", \"robots\": [";
  for (std::size_t i = 0; i < ends.size(); ++i) {
    json += (i > 0 ? ", " : "") + (ends[i].json.empty() ? "null" : ends[i].json);
  }
  json += "]}\n";
  save_report(files, json, outputs);
  failures.insert(failures.end(), outputs.failures.begin(), outputs.failures.end());
  if (mapping.json) {
    fmt::print("{}", json);
  } else if (!mapping.quiet) {
    for (std::size_t i = 0; i < team.size(); ++i) {
      fmt::print("robot {}\n{}", i + 1,
                 nav::exploration_text(explored_by(team.member(i).robot, building.record(i), team.driving_ns())));
    }
    fmt::print("{} robots, {:.0f} s in {:.1f} s; {}\n", team.size(), static_cast<double>(team.driving_ns()) * 1e-9,
               run_s,
               are_equal ? "all hold the same map: " + hashes[first_alive] : "they do NOT hold the same map yet");
    for (const mapper::WrittenFile& file : outputs.files) fmt::print("  {}  {}\n", file.path, file.what);
  }
  for (const hal::Error& failure : failures) (void)fail(failure.text);
  return failures.empty() ? kExitDone : kExitFailed;
}

}  // namespace g3d
