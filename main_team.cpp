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
#include "main_explore.hpp"
#include "main_robot.hpp"
#include "main_save.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "mapper/block_source.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/report.hpp"
#include "mapper/summary.hpp"
#include "mapper/version.hpp"
#include "nav/coverage.hpp"
#include "nav/exploration_report.hpp"
#include "nav/outputs.hpp"
#include "nav/robot.hpp"
#include "net/map_sharing.hpp"
#include "net/sim_radio.hpp"
#include "net/team_frame.hpp"
#include "net/team_report.hpp"
#include "net/team_talk.hpp"
#include "net/team_trouble.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kTeamSecond_ns = 1'000'000'000;
/// Submaps of a robot, at most; see JoinRule, and one that is ahead of them.
constexpr std::size_t kTeamSubmaps = 80;
/// After the last robot is home, for what is still on its way.
constexpr double kTeamSettle_s = 60.0;

/// Radio waves over the floor: so far, and everybody's own luck.
net::RadioModel radio_model(const SimOptions& options) {
  net::RadioModel model;
  model.loss = options.loss;
  model.late = options.loss > 0.0 ? 0.05 : 0.0;
  model.doubled = options.loss > 0.0 ? 0.02 : 0.0;
  model.seed = options.mapping.seed;
  return model;
}

class Team {
 public:
  Team(hal::SimBuilding& building, const std::vector<nav::RobotConfig>& configs, const SimOptions& options,
       net::TeamTrouble trouble, const hal::Observable& observable, double rate_hz)
      : building_(building),
        trouble_(std::move(trouble)),
        coverage_(observable),
        frame_(hal::make_frame(building.camera())),
        frame_period_ns_(static_cast<hal::TimeNs>(1e9 / rate_hz)),
        radio_(static_cast<std::uint32_t>(configs.size()), radio_model(options),
               [this, &options](std::uint32_t from, std::uint32_t to, hal::TimeNs now_ns) {
                 return !net::is_cut(trouble_.cuts, from, to, now_ns) &&
                        (options.radio_range_m <= 0.0 || distance_m(from, to) <= options.radio_range_m);
               }) {
    for (std::uint32_t i = 0; i < configs.size(); ++i) {
      members_.push_back(std::make_unique<Member>(*this, i, configs[i], clock_, options));
    }
  }

  void run(hal::TimeNs limit_ns, bool show_progress) {
    const hal::TimeNs start_ns = clock_.now();
    while (!is_stop_requested() && now_ns_ < limit_ns && !all_are_home()) {
      advance();
      if (show_progress && now_ns_ % kTeamSecond_ns == 0) show(start_ns);
    }
    driving_ns_ = now_ns_;
    for (const auto& member : members_) member->robot.finish_map();
    const auto settled_ns = now_ns_ + static_cast<hal::TimeNs>(kTeamSettle_s * 1e9);
    while (!is_stop_requested() && now_ns_ < settled_ns && !(all_have_told() && all_hold_the_same())) advance();
    settle_ns_ = now_ns_ - driving_ns_;
    if (show_progress) fmt::print(stderr, "\n");
  }

  struct Member final : net::Link {
    Member(Team& of, std::uint32_t its_number, const nav::RobotConfig& config, hal::Clock& clock,
           const SimOptions& options)
        : team(of),
          number(its_number),
          robot(config, clock),
          sharing(sharing_options(config, options, number), robot.mapper().map(), *this),
          talk({}, sharing.gossip(), sharing.store(), 0) {
      robot.share(&sharing.view());
      // All maps are in the world's frame: where each begins is known.
      sharing.publish_pose({}, 0);
    }
    static net::SharingOptions sharing_options(const nav::RobotConfig& config, const SimOptions& options,
                                               std::uint32_t number) {
      net::SharingOptions sharing;
      sharing.gossip.self = {number + 1, 1};
      sharing.gossip.seed = options.mapping.seed;
      sharing.gossip.bandwidth_Bps = options.radio_Bps;
      if (config.loops) {
        sharing.is_chain = true;
        sharing.most_submaps = kTeamSubmaps * static_cast<std::size_t>(options.robots);
      }
      // Each base drifts in its own way: where it has been is what its map says, fitted to the others'.
      if (options.mapping.odometry == "aligned") sharing.refine.emplace().is_lockstep = true;
      return sharing;
    }
    /// What it tells of itself beside what its navigator says.
    [[nodiscard]] net::StateWord state() const {
      net::StateWord word;
      word.mission = robot.navigator().mission().state();
      word.battery_percent =
          static_cast<std::uint8_t>(std::lround(100.0 * std::clamp(robot.base().battery_charge, 0.0, 1.0)));
      word.radius_m = static_cast<float>(hal::kobuki::kBodyRadius_m);
      word.map_incarnation = sharing.gossip().options().self.incarnation;
      return word;
    }
    [[nodiscard]] bool is_alive() const { return died_ns == 0; }
    /// Nothing more is to be expected of it.
    [[nodiscard]] bool is_through() const { return !is_alive() || robot.navigator().mission().is_over(); }
    bool send(net::Address to, mapper::ByteSpan message) override {
      const std::uint32_t station =
          to == net::kEverybody ? net::SimRadio::kEveryStation : static_cast<std::uint32_t>(to - 1);
      team.radio_.send(number, station, message, team.now_ns_);
      return true;
    }
    Team& team;
    std::uint32_t number;
    nav::Robot robot;
    net::MapSharing sharing;
    net::TeamTalk talk;
    PlaceError place_error;
    std::vector<hal::StampedPose> way;
    std::uint64_t frames = 0;
    hal::TimeNs next_frame_ns = 0;
    hal::TimeNs home_ns = 0;
    hal::TimeNs died_ns = 0;  ///< 0: it lives
    double fraction = 0.0;
  };
  [[nodiscard]] std::size_t size() const { return members_.size(); }
  [[nodiscard]] Member& member(std::size_t i) { return *members_[i]; }
  [[nodiscard]] hal::TimeNs now_ns() const { return now_ns_; }
  [[nodiscard]] hal::TimeNs driving_ns() const { return driving_ns_; }
  [[nodiscard]] hal::TimeNs settle_ns() const { return settle_ns_; }
  [[nodiscard]] hal::SimBuilding& building() { return building_; }
  [[nodiscard]] const net::SimRadio& radio() const { return radio_; }
  /// That live.
  [[nodiscard]] bool all_hold_the_same() const {
    const auto first = std::find_if(members_.begin(), members_.end(), [](const auto& m) { return m->is_alive(); });
    return std::all_of(first, members_.end(), [&](const auto& member) {
      return !member->is_alive() || member->sharing.store().digest() == (*first)->sharing.store().digest();
    });
  }

 private:
  [[nodiscard]] double distance_m(std::uint32_t a, std::uint32_t b) const {
    const hal::PlanarPose from = building_.T_world_base(a);
    const hal::PlanarPose to = building_.T_world_base(b);
    return std::hypot(from.x_m - to.x_m, from.y_m - to.y_m);
  }
  [[nodiscard]] bool all_are_home() const {
    return std::all_of(members_.begin(), members_.end(), [](const auto& member) { return member->is_through(); });
  }

  /// What was put right at the end is published.
  [[nodiscard]] bool all_have_told() const {
    return std::all_of(members_.begin(), members_.end(), [&](const auto& member) {
      return member->robot.loops() == nullptr ||
             (now_ns_ > driving_ns_ + 2 * kTeamSecond_ns && member->sharing.chain_writer().is_up_to_date());
    });
  }

  /// 20 ms: what the bases say, frames that are due, and the radio.
  void advance() {
    now_ns_ += hal::kobuki::kPacketPeriod_ns;
    building_.advance_to(now_ns_);
    for (const net::RobotDeath& death : trouble_.deaths) {
      Member& member = *members_[death.robot];
      if (now_ns_ < death.at_ns || !member.is_alive()) continue;
      member.died_ns = now_ns_;
      radio_.forget(death.robot);
    }
    for (const auto& member : members_) {
      if (!member->is_alive()) continue;
      member->robot.on_line(building_.line(member->number), now_ns_);
      if (now_ns_ >= member->next_frame_ns) take_frame(*member);
    }
    radio_.deliver(now_ns_, [this](std::uint32_t from, std::uint32_t to, mapper::ByteSpan message) {
      if (members_[to]->is_alive()) members_[to]->sharing.on_message({from + 1, 1, from + 1}, message, now_ns_);
    });
    for (const auto& member : members_) {
      if (!member->is_alive()) continue;
      const hal::Pose& T_world_map = member->sharing.T_world_map();
      const nav::TeamWord word = net::in_world(member->robot.team_word(now_ns_), T_world_map);
      if (member->talk.on_time(word, member->state(), now_ns_)) {
        member->robot.on_team(net::in_map(member->talk.sight(), T_world_map), now_ns_);
      }
      if (const auto* loops = member->robot.loops(); loops != nullptr && loops->is_chain_at_rest()) {
        member->sharing.publish_chain(loops->chain(), now_ns_);
      }
      const auto slots = member->sharing.on_time(now_ns_);
      if (!slots.empty()) member->robot.on_shared(slots, now_ns_);
    }
    if (now_ns_ % kTeamSecond_ns == 0) sample();
  }

  void take_frame(Member& member) {
    building_.render(member.number, frame_);
    frame_.stamp_ns = now_ns_;
    const std::uint64_t before = member.robot.frames().integrated;
    if (building_.pass_on(member.number, frame_, now_ns_)) member.robot.on_frame(frame_, now_ns_);
    if (member.robot.frames().integrated != before) {
      member.way.push_back({frame_.stamp_ns, *member.robot.last_frame_pose()});
      member.sharing.note_changed(member.robot.mapper().changed_slots());
    }
    ++member.frames;
    member.next_frame_ns = static_cast<hal::TimeNs>(member.frames) * frame_period_ns_;
  }

  void sample() {
    for (const auto& member : members_) {
      if (!member->is_alive()) continue;
      member->place_error.note(building_.T_world_base(member->number), member->robot.T_world_base());
      nav::Navigator& navigator = member->robot.navigator();
      member->fraction = coverage_.fraction(navigator.ground().states());
      navigator.report().note_coverage(member->fraction, now_ns_);
      if (member->home_ns == 0 && navigator.mission().is_over()) member->home_ns = now_ns_;
    }
  }

  void show(hal::TimeNs start_ns) const {
    const double simulated_s = static_cast<double>(now_ns_) / 1e9;
    const double real_s = std::max(1e-3, static_cast<double>(clock_.now() - start_ns) / 1e9);
    std::string text;
    for (const auto& member : members_) {
      text += fmt::format("  {}: {:.1f} % {}", member->number + 1, 100.0 * member->fraction,
                          nav::name_of(member->robot.navigator().mission().state()));
    }
    fmt::print(stderr, "\r{:6.0f} s  {:5.1f} x real time{}   ", simulated_s, simulated_s / real_s, text);
  }

  hal::SimBuilding& building_;
  net::TeamTrouble trouble_;
  nav::CoverageMeter coverage_;
  hal::RealClock clock_;
  hal::Frame frame_;
  hal::TimeNs frame_period_ns_;
  hal::TimeNs now_ns_ = 0;
  hal::TimeNs driving_ns_ = 0;
  hal::TimeNs settle_ns_ = 0;
  net::SimRadio radio_;
  std::vector<std::unique_ptr<Member>> members_;
};

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
