// SPDX-License-Identifier: Apache-2.0
// `g3dmap run` for a board without base and camera: it hears the fleet, passes layers on, and writes the one map of all
// robots, from time to time and at the end.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "hal/linux/control_socket.hpp"
#include "hal/linux/cpu_time.hpp"
#include "hal/sim/disk_faults.hpp"
#include "main_commands.hpp"
#include "main_explore.hpp"
#include "main_network.hpp"
#include "main_robot.hpp"
#include "main_save.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "mapper/files/checkpoint.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/report.hpp"
#include "mapper/summary.hpp"
#include "mapper/version.hpp"
#include "nav/outputs.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kStationLook_ns = 50'000'000;
constexpr hal::TimeNs kStationProgress_ns = 500'000'000;
constexpr double kStationCheckpoint_s = 60.0;

/// What is said of a robot and would be ignored here; nothing: all is well.
std::optional<std::string> station_contradiction(const board::Board& board, const LiveOptions& options) {
  const char* what = nullptr;
  if (!options.camera.empty()) what = "--camera";
  if (!options.area.empty()) what = "--area";
  if (!options.start.empty()) what = "--start";
  if (options.drift > 0.0) what = "--drift";
  if (!options.record.empty()) what = "--record";
  if (options.mapping.loops) what = "--loops";
  if (options.mapping.odometry != "given") what = "--odometry";
  if (!options.staging.at.empty()) what = "--at";
  if (options.staging.battery_min > 0.0) what = "--battery";
  if (std::any_of(options.staging.fail.begin(), options.staging.fail.end(),
                  [](const std::string& fault) { return !fault.starts_with("disk:"); })) {
    what = "--fail with anything but a disk";
  }
  if (what != nullptr) {
    return fmt::format("{}: base.line is \"none\", so there is no robot for {}; leave it out",
                       options.mapping.board_path, what);
  }
  if (board.camera_source != "none") {
    return fmt::format("{}: base.line is \"none\", so camera.source must be \"none\" as well",
                       options.mapping.board_path);
  }
  if (!has_fleet(board)) {
    return fmt::format(
        "{}: a base station needs a fleet to listen to: give --key FILE, or network.key in the board file",
        options.mapping.board_path);
  }
  if (options.mapping.out_dir.empty() && options.mapping.checkpoint_s > 0.0) {
    return "--checkpoint needs a folder: give --out";
  }
  return std::nullopt;
}

class Station {
 public:
  Station(const board::Board& board, const LiveOptions& options)
      : board_(board),
        options_(options),
        no_own_map_({static_cast<float>(board.map_resolution_m)}, mapper_config(board, options.mapping).capacity) {
    output_.band = {static_cast<float>(board.ground_low_m), static_cast<float>(board.ground_high_m)};
    output_.meta.steps = mapper_config(board, options.mapping).steps;
  }

  [[nodiscard]] hal::Result<void> begin(FleetPlan plan) {
    auto fleet = Fleet::open(std::move(plan), no_own_map_, clock_);
    if (!fleet) return fleet.error();
    fleet_ = std::move(fleet).value();
    const std::string& out_dir = options_.mapping.out_dir;
    if (options_.staging.control.empty() && out_dir.empty()) return {};
    const std::string path = options_.staging.control.empty() ? out_dir + "/control" : options_.staging.control;
    auto control = hal::ControlSocket::open(path, [this](std::string_view word) { return answer(word); });
    if (!control) return control.error();
    control_ = std::move(control).value();
    return {};
  }

  void run(bool show_progress) {
    const hal::TimeNs start_ns = clock_.now();
    const hal::TimeNs end_ns =
        options_.duration_s > 0.0 ? start_ns + static_cast<hal::TimeNs>(options_.duration_s * 1e9) : INT64_MAX;
    const double period_s = options_.mapping.checkpoint_s > 0.0 ? options_.mapping.checkpoint_s : kStationCheckpoint_s;
    const auto period_ns = static_cast<hal::TimeNs>(period_s * 1e9);
    hal::TimeNs next_show_ns = start_ns;
    hal::TimeNs next_save_ns = start_ns + period_ns;
    fleet_->start();
    while (!is_over() && clock_.now() < end_ns) {
      clock_.sleep_until(std::min(end_ns, clock_.now() + kStationLook_ns));
      if (show_progress && clock_.now() >= next_show_ns) {
        next_show_ns = clock_.now() + kStationProgress_ns;
        show(clock_.now() - start_ns);
      }
      if (options_.mapping.out_dir.empty() || clock_.now() < next_save_ns) continue;
      save_meanwhile();
      next_save_ns = clock_.now() + period_ns;
    }
    if (show_progress) fmt::print(stderr, "\n");
    fleet_->settle(options_.network.settle_s.value_or(0.0), [] { return is_stop_requested(); });
    fleet_->stop();
    control_.reset();
    run_s_ = static_cast<double>(clock_.now() - start_ns) / 1e9;
  }

  [[nodiscard]] const Fleet& fleet() const { return *fleet_; }
  [[nodiscard]] const nav::OutputOptions& output() const { return output_; }
  [[nodiscard]] double run_s() const { return run_s_; }
  [[nodiscard]] int saves() const { return saves_; }
  [[nodiscard]] const std::string& first_save_error() const { return first_save_error_; }

 private:
  [[nodiscard]] bool is_over() const { return is_stop_requested() || is_told_to_stop_.load(); }

  std::string answer(std::string_view word) {
    if (auto peers = fleet_->answer(word)) return *peers;
    if (word == "status") return fleet_->answer("peers").value();
    if (word == "stop") {
      is_told_to_stop_.store(true);
      return "{\"state\": \"stopped\"}\n";
    }
    return "{\"error\": \"this is a base station; say status or stop, or ask g3dmap peers\"}\n";
  }

  void show(hal::TimeNs since_ns) const {
    net::SharingBrief brief;
    if (fleet_->thread().brief().read(brief) == 0) return;
    fmt::print(stderr, "\r{:6.0f} s  {}     ", static_cast<double>(since_ns) / 1e9, brief_text(brief));
  }

  /// All files, each replaced whole. What fails is tried again the next time.
  void save_meanwhile() {
    net::SharingBrief brief;
    if (fleet_->thread().brief().read(brief) == 0 || brief.digest == saved_digest_) return;
    const auto copy = mapper::snapshot_of(fleet_->thread().others());
    if (copy == nullptr) {
      note_save_error("no memory for a copy of the map; a smaller --memory leaves more room");
      return;
    }
    const nav::Outputs outputs = nav::write_outputs(*copy, output_, options_.mapping.out_dir);
    if (!outputs.failures.empty()) {
      note_save_error(outputs.failures.front().text);
      return;
    }
    saved_digest_ = brief.digest;
    ++saves_;
  }
  void note_save_error(const std::string& text) {
    if (first_save_error_.empty()) first_save_error_ = text;
  }

  const board::Board& board_;
  const LiveOptions& options_;
  hal::RealClock clock_;
  const mapper::VoxelMap no_own_map_;
  nav::OutputOptions output_;
  std::unique_ptr<Fleet> fleet_;
  std::unique_ptr<hal::ControlSocket> control_;
  std::atomic<bool> is_told_to_stop_{false};
  std::uint64_t saved_digest_ = 0;
  int saves_ = 0;
  std::string first_save_error_;
  double run_s_ = 0.0;
};

mapper::RunReport make_report(const Station& station, const mapper::VoxelMap& merged, const board::Board& board,
                              const std::string& command_line) {
  mapper::RunReport report;
  const mapper::MapCounts counts = merged.counts();
  report.resolution_m = board.map_resolution_m;
  report.occupied = counts.occupied;
  report.free = counts.free;
  report.memory_bytes = merged.memory().used_bytes;
  report.hash = mapper::map_hash(merged);
  report.command = command_line;
  report.version = mapper::version();
  report.board = board.name;
  if (station.saves() > 0) report.notes.push_back(fmt::format("the map was saved {} times meanwhile", station.saves()));
  if (std::string warning = station.fleet().warning(); !warning.empty()) report.notes.push_back(std::move(warning));
  if (!station.first_save_error().empty()) {
    report.notes.push_back("the map could not be saved meanwhile: " + station.first_save_error());
  }
  return report;
}

}  // namespace

int run_station(const LiveOptions& options, const std::string& command_line) {
  const MappingOptions& mapping = options.mapping;
  auto board = effective_board(mapping);
  if (!board) return fail(board.error().text);
  if (const auto said = set_network(options.network, board.value()); !said) return bad_usage(said.error().text);
  if (const auto problem = station_contradiction(board.value(), options)) return bad_usage(*problem);
  const auto staging = read_staging(options.staging);
  if (!staging) return bad_usage(staging.error().text);
  auto plan = plan_fleet(board.value(), false);
  if (!plan) return fail_as(plan.error());
  if (!mapping.out_dir.empty()) {
    if (const auto folder = open_folder(mapping.out_dir); !folder) return fail(folder.error().text);
  }
  catch_stop_signals();
  hal::RealClock clock;
  hal::DiskFaults bad_disk(staging.value().faults, [&clock, begin_ns = clock.now()] { return clock.now() - begin_ns; });
  const hal::DiskInstead disk_instead(bad_disk);
  Station station(board.value(), options);
  if (const auto begun = station.begin(std::move(plan).value()); !begun) return fail_as(begun.error());
  station.run(!mapping.quiet && isatty(STDERR_FILENO) != 0);

  const auto merged = station.fleet().whole_map();
  mapper::RunReport report = make_report(station, merged->map(), board.value(), command_line);
  nav::Outputs outputs;
  RunFiles files;
  if (!mapping.out_dir.empty()) {
    files.folder = mapping.out_dir;
    files.patience_s = mapping.patience_s;
    files.map = &merged->map();
    files.options = station.output();
    files.is_given_up = [was = is_stop_requested()] { return !was && is_stop_requested(); };
    outputs = save_run(files);
  }
  report.file_bytes = outputs.map_file_bytes;
  if (outputs.late_files > 0) report.notes.push_back(late_files_note(outputs.late_files));
  report.write_more = [&](mapper::JsonWriter& json) {
    station.fleet().write(json, report.hash, station.run_s());
    write_cpu(json, std::vector<nav::ThreadTime>{{"sharing", station.fleet().thread().cpu_s()}}, station.run_s());
  };
  const std::string json = to_json(report);
  if (!mapping.out_dir.empty()) save_report(files, json, outputs);
  if (mapping.json) {
    fmt::print("{}", json);
  } else if (!mapping.quiet) {
    fmt::print("{}{}", net::to_text(station.fleet().thread().status()),
               summary_text(report, station.run_s(), outputs.files));
  }
  for (const hal::Error& failure : outputs.failures) (void)fail(failure.text);
  return outputs.failures.empty() ? kExitDone : kExitFailed;
}

}  // namespace g3d
