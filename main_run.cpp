// SPDX-License-Identifier: Apache-2.0
// `g3dmap replay`, and what it shares with `g3dmap sim`: a camera, its poses, a mapper and a writer, joined and let
// run.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>
#include <utility>

#include "hal/clock.hpp"
#include "hal/image/file_bytes.hpp"
#include "hal/kinect/openni_parts.hpp"
#include "hal/replay/recorded_odometry.hpp"
#include "hal/replay/recorded_poses.hpp"
#include "hal/replay/replay_camera.hpp"
#include "hal/replay/standing_pose.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "main_commands.hpp"
#include "main_paging.hpp"
#include "main_record.hpp"
#include "main_run.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/files/checkpoint.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/mapper.hpp"
#include "mapper/pipeline.hpp"
#include "mapper/progress_bar.hpp"
#include "mapper/report.hpp"
#include "mapper/run_sink.hpp"
#include "mapper/scan_mask.hpp"
#include "mapper/summary.hpp"
#include "mapper/version.hpp"
#include "nav/outputs.hpp"

namespace g3d {
namespace {

// The first Ctrl-C lets the frames under way finish and saves the map, the second one ends the program at once.
std::atomic<mapper::Pipeline*> running_pipeline{nullptr};
std::atomic<int> pipeline_stops{0};

void stop_pipeline(int) {
  if (pipeline_stops.fetch_add(1) > 0) _exit(130);
  if (mapper::Pipeline* pipeline = running_pipeline.load()) pipeline->request_stop();
}

void catch_stop_signals(mapper::Pipeline& pipeline) {
  running_pipeline.store(&pipeline);
  struct sigaction action {};
  action.sa_handler = stop_pipeline;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;  // a file that is being read or written is not to blame
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

hal::Result<void> make_folder(const std::string& path) {
  std::error_code code;
  std::filesystem::create_directories(path, code);
  if (code) {
    return hal::Error{hal::Reason::io_error,
                      fmt::format("{}: cannot create this folder: {}; choose another --out", path, code.message())};
  }
  return {};
}

mapper::ProgressStyle progress_style(const MappingOptions& options) {
  if (options.quiet) return mapper::ProgressStyle::quiet;
  return isatty(STDERR_FILENO) != 0 ? mapper::ProgressStyle::terminal : mapper::ProgressStyle::plain;
}

/// `whole`: the map, whatever is not in memory included.
mapper::RunReport make_report(const mapper::Pipeline& pipeline, const mapper::BlockSource& whole,
                              const board::Board& board, std::uint64_t seed, const std::string& command_line) {
  mapper::RunReport report;
  report.frames = pipeline.frames();
  for (std::size_t i = 0; i < mapper::kStageCount; ++i) {
    const auto stage = static_cast<mapper::Stage>(i);
    report.stages.push_back({to_string(stage), pipeline.times(stage)});
  }
  report.resolution_m = board.map_resolution_m;
  report.hash = map_hash(whole);
  report.refused_blocks = pipeline.refused_blocks();
  report.command = command_line;
  report.version = mapper::version();
  report.seed = seed;
  report.threads = board.map_threads;
  report.board = board.name;
  if (pipeline.was_interrupted()) report.notes.emplace_back("interrupted: what was mapped until then is saved");
  if (pipeline.pool_full_frames() > 0) {
    report.notes.push_back(
        fmt::format("the map's memory was full for {} frames and took no new blocks; raise --memory, or keep what is "
                    "far on disk by --window",
                    pipeline.pool_full_frames()));
  }
  return report;
}

std::string checkpoint_note(const mapper::Checkpoint& checkpoint) {
  std::string note = fmt::format("map.g3d was saved at {} checkpoints", checkpoint.saves());
  if (checkpoint.failed_saves() > 0) {
    note += fmt::format(", {} failed, the first one: {}", checkpoint.failed_saves(), checkpoint.first_error());
  }
  return note;
}

/// Frames were written as they were mapped; where they were is known better at the end.
hal::Result<void> correct_trajectory(const std::string& path, const mapper::submaps::LoopedMap& looped) {
  auto poses = hal::read_trajectory(path);
  if (!poses) return poses.error();
  for (hal::StampedPose& pose : poses.value()) {
    pose.T_world_camera = looped.corrected(pose.stamp_ns, pose.T_world_camera);
  }
  return hal::write_trajectory(path, poses.value());
}

}  // namespace

int map_source(Source source, const board::Board& board, const MappingOptions& options,
               const std::string& command_line) {
  if (options.checkpoint_s > 0.0 && board.map_window_radius_m > 0.0) {
    return bad_usage("--checkpoint saves what is in memory, so it does not go with --window; give one of them");
  }
  if (const auto problem = loops_problem(options)) return bad_usage(*problem);
  if (const auto made = make_folder(options.out_dir); !made) return fail(made.error().text);
  const std::string trajectory_path = options.out_dir + "/trajectory.tum";
  auto trajectory = hal::TrajectoryWriter::create(trajectory_path);
  if (!trajectory) return fail(trajectory.error().text);

  std::vector<std::uint16_t> mask;
  if (!options.mask_path.empty()) {
    auto loaded = mapper::load_scan_mask(options.mask_path, source.camera.model());
    if (!loaded) return fail(loaded.error().text);
    mask = std::move(loaded).value();
  }

  mapper::MapperConfig config = mapper_config(board, options);
  if (options.loops) config.backend = mapper::Backend::cpu;
  const auto align = align_options(options);
  if (align) config.surface_slots = static_cast<std::uint32_t>(align->surface.slots);
  if (const auto problem = mapper::config_problem(config, source.camera.model())) return fail(*problem);
  mapper::Mapper mapper(config, source.camera.model(), mask);
  if (const auto missing = missing_card(mapper, options)) return fail(*missing);
  hal::RealClock clock;
  std::unique_ptr<mapper::align::Aligner> aligner;
  std::unique_ptr<mapper::submaps::LoopedMap> looped;
  auto pages = open_pages(board, options);
  if (!pages) return fail(pages.error().text);
  if (align && options.loops) {
    mapper::submaps::LoopedOptions looped_options;
    looped_options.align = *align;
    looped_options.window = {board.map_window_radius_m, mapper.config().near_m, mapper.config().far_m};
    looped = std::make_unique<mapper::submaps::LoopedMap>(mapper.map(), source.camera.model(), looped_options,
                                                          std::move(pages).value());
  } else if (align) {
    aligner = std::make_unique<mapper::align::Aligner>(*align, source.camera.model(), mapper.fit_card());
  }
  const std::string odometry_path = options.out_dir + "/odometry.tum";
  std::optional<hal::TrajectoryWriter> odometry;
  if (options.odometry == "aligned") {
    auto created = hal::TrajectoryWriter::create(odometry_path);
    if (!created) return fail(created.error().text);
    odometry.emplace(std::move(created).value());
  }
  mapper::ProgressBar bar(stderr, progress_style(options), source.camera.frame_count());
  mapper::RunSink sink(trajectory.value(), bar, clock, odometry ? &*odometry : nullptr);
  std::unique_ptr<mapper::RollingWindow> window;
  if (looped == nullptr && pages.value() != nullptr) {
    window = make_window(mapper, source.camera.model(), board, options, std::move(pages).value());
  }
  const auto footprint = start_footprint(board, options);
  if (!footprint) return bad_usage(footprint.error().text);
  mapper::Pipeline pipeline(source.camera, source.poses, mapper, sink, clock,
                            {.rate = options.rate,
                             .window = window.get(),
                             .footprint = footprint.value(),
                             .aligner = aligner.get(),
                             .looped = looped.get()});
  if (source.run != nullptr && source.run->footprint && !footprint.value()) {
    mapper.free_footprint(source.run->footprint->at_m, source.run->footprint->radius_m,
                          source.run->footprint->height_m);
  }
  catch_stop_signals(pipeline);
  std::unique_ptr<mapper::Checkpoint> checkpoint;
  if (options.checkpoint_s > 0.0) {
    checkpoint = std::make_unique<mapper::Checkpoint>(
        mapper.map(), mapper::CheckpointConfig{.period_s = options.checkpoint_s,
                                               .path = options.out_dir + "/map.g3d",
                                               .meta = {.T_world_map = {}, .steps = mapper.config().steps}});
  }
  const hal::TimeNs start_ns = clock.now();
  pipeline.run();
  if (checkpoint != nullptr) checkpoint->stop();
  const double run_s = static_cast<double>(clock.now() - start_ns) / 1e9;
  running_pipeline.store(nullptr);

  std::vector<hal::Error> failures;
  if (const auto finished = sink.finish(); !finished) failures.push_back(finished.error());
  if (looped != nullptr) {
    if (const auto corrected = correct_trajectory(trajectory_path, *looped); !corrected) {
      failures.push_back(corrected.error());
    }
  }
  const std::uint64_t memory_bytes = mapper.map().memory().used_bytes;
  const GatheredMap gathered = gather_map(mapper.map(), window.get(), looped.get());
  const mapper::BlockSource& whole = *gathered.whole;
  mapper::RunReport report = make_report(pipeline, whole, board, options.seed, command_line);
  const mapper::MapCounts counts = gathered.is_all_in_memory ? mapper.map().counts() : measure(whole).value().counts;
  report.occupied = counts.occupied;
  report.free = counts.free;
  report.memory_bytes = memory_bytes;
  report.paging = gathered.paging;
  report_mapper(mapper, report);
  report_alignment(looped != nullptr ? &looped->aligner() : aligner.get(), options, report);
  if (looped != nullptr) report.loops = looped->report();
  report.notes.insert(report.notes.begin(), source.notes.begin(), source.notes.end());
  if (source.run != nullptr) {
    report.notes.push_back(compare_with_run(*source.run, report.hash, report.frames.integrated, source.run_frames));
  }
  if (!gathered.first_error.empty()) report.notes.push_back(gathered.first_error);
  if (!gathered.is_all_in_memory) {
    report.notes.push_back(
        fmt::format("the whole map is larger than {} MB of memory: only map.g3d was written; for the other files, "
                    "g3dmap export {}/map.g3d --to FILE where there is more memory",
                    board.map_memory_mb, options.out_dir));
  }
  if (checkpoint != nullptr) report.notes.push_back(checkpoint_note(*checkpoint));
  if (const std::string error = source.camera.last_error(); !error.empty()) report.notes.push_back(error);

  std::vector<hal::Pose> poses;
  if (const auto recorded = hal::read_trajectory(trajectory_path); recorded.ok()) {
    for (const hal::StampedPose& pose : recorded.value()) poses.push_back(pose.T_world_camera);
  }
  nav::OutputOptions output_options;
  output_options.trajectory = poses;
  output_options.band = {static_cast<float>(board.ground_low_m), static_cast<float>(board.ground_high_m)};
  output_options.meta.steps = mapper.config().steps;
  nav::Outputs outputs = gathered.is_all_in_memory ? nav::write_outputs(mapper.map(), output_options, options.out_dir)
                                                   : nav::write_native_output(whole, output_options, options.out_dir);
  report.file_bytes = outputs.map_file_bytes;
  failures.insert(failures.end(), outputs.failures.begin(), outputs.failures.end());
  std::error_code no_size;
  if (const auto bytes = std::filesystem::file_size(trajectory_path, no_size); !no_size) {
    outputs.files.push_back({trajectory_path, "the camera's way", bytes});
  }
  if (const auto bytes = std::filesystem::file_size(odometry_path, no_size); odometry && !no_size) {
    outputs.files.push_back({odometry_path, "the same way as odometry had it", bytes});
  }
  const std::string json = to_json(report);
  const std::string report_path = options.out_dir + "/report.json";
  if (const auto written = hal::write_file_atomic(report_path, json); !written) {
    failures.push_back(written.error());
  } else {
    outputs.files.push_back({report_path, "what happened", json.size()});
  }

  if (options.json) {
    fmt::print("{}", json);
  } else if (!options.quiet) {
    fmt::print("{}", summary_text(report, run_s, outputs.files));
  }
  for (const hal::Error& failure : failures) (void)fail(failure.text);
  if (report.frames.integrated == 0 && !pipeline.was_interrupted()) {
    return fail(report.frames.delivered == 0 ? "the source delivered no frames, so the map is empty"
                                             : "no frame reached the map; the report counts why under frames.dropped");
  }
  return failures.empty() ? kExitDone : kExitFailed;
}

namespace {

/// The recording's own poses; where it has none, those that the odometry of its base gives.
hal::Result<std::unique_ptr<hal::RecordedPoses>> replay_poses(const ReplayOptions& options, const board::Board& board,
                                                              std::vector<std::string>& notes) {
  const std::string base_path = options.log_dir + "/kobuki.bin";
  const bool has_poses = !options.poses_path.empty() || hal::find_trajectory(options.log_dir).ok();
  if (has_poses || !std::filesystem::exists(base_path)) {
    return hal::RecordedPoses::open(options.log_dir, options.poses_path);
  }
  const auto log = hal::KobukiLog::open(base_path);
  if (!log) return log.error();
  hal::RecordedOdometry odometry = hal::recompute_odometry(log.value(), mount_pose(board));
  if (odometry.poses.empty()) {
    return hal::Error{hal::Reason::malformed,
                      fmt::format("{}: not one good packet of a base among {} records, so there is no odometry; give a "
                                  "file of poses with --poses",
                                  base_path, log.value().record_count())};
  }
  notes.push_back(fmt::format("poses from the base's odometry: {} packets, {:.2f} m, {} rejected",
                              odometry.rejects.accepted_frames, odometry.path_m, odometry.rejects.total()));
  return std::make_unique<hal::RecordedPoses>(std::move(odometry.poses));
}

/// Without odometry only the start is known: from the recording's poses if it has some, else as the board's camera
/// stands.
hal::Result<std::unique_ptr<hal::PoseSource>> poses_or_start(const ReplayOptions& options, const board::Board& board,
                                                             std::vector<std::string>& notes) {
  auto recorded = replay_poses(options, board, notes);
  if (options.mapping.odometry != "none") {
    if (!recorded) return recorded.error();
    return std::unique_ptr<hal::PoseSource>(std::move(recorded).value());
  }
  if (!recorded && !options.poses_path.empty()) return recorded.error();
  std::optional<hal::Pose> start;
  if (recorded) start = recorded.value()->first();
  if (!start) notes.emplace_back("no pose is known: the map stands as if the first frame came from the board's camera");
  return std::unique_ptr<hal::PoseSource>(std::make_unique<hal::StandingPose>(start.value_or(mount_pose(board))));
}

}  // namespace

namespace {

/// An OpenNI recording has no poses of its own: from a file, or none at all.
int run_oni_replay(const ReplayOptions& options, const board::Board& board, const std::string& command_line) {
  if (options.poses_path.empty() && options.mapping.odometry != "none") {
    return bad_usage(
        fmt::format("{}: an .oni recording has no poses: give --poses FILE, or --odometry none for a camera "
                    "whose way only its frames tell",
                    options.log_dir));
  }
  std::optional<hal::kinect::Calibration> calibration;
  if (board.camera_calibration != "none") {
    auto loaded = hal::kinect::load_calibration(board.camera_calibration);
    if (!loaded) return fail(loaded.error().text);
    calibration = std::move(loaded).value();
  }
  auto camera = hal::kinect::open_recording(options.log_dir, calibration ? &*calibration : nullptr);
  if (!camera) return fail(camera.error().text);
  std::vector<std::string> notes;
  std::unique_ptr<hal::PoseSource> poses = std::make_unique<hal::StandingPose>(mount_pose(board));
  if (!options.poses_path.empty()) {
    auto recorded = hal::RecordedPoses::open(options.log_dir, options.poses_path);
    if (!recorded) return fail(recorded.error().text);
    poses = std::move(recorded).value();
  }
  return map_source({*camera.value(), *poses, std::move(notes)}, board, options.mapping, command_line);
}

}  // namespace

int run_replay(const ReplayOptions& options, const std::string& command_line) {
  MappingOptions mapping = options.mapping;
  mapping.board_path = board_of_recording(options.log_dir, mapping.board_path);
  const auto board = effective_board(mapping);
  if (!board) return fail(board.error().text);
  if (options.log_dir.ends_with(".oni")) return run_oni_replay(options, board.value(), command_line);
  auto camera = hal::ReplayCamera::open(options.log_dir);
  if (!camera) return fail(camera.error().text);
  std::vector<std::string> notes = camera.value()->warnings();
  if (!mapping.quiet) {
    for (const std::string& warning : camera.value()->warnings()) fmt::print(stderr, "g3dmap: warning: {}\n", warning);
  }
  if (options.poses_path.empty() && mapping.odometry == "given") {
    auto run = open_recorded_run(options.log_dir);
    if (!run) return fail(run.error().text);
    if (run.value()) {
      const RecordedRun& recorded = *run.value();
      mapping.no_colour = mapping.no_colour || !recorded.log.with_colour;
      hal::MaskedCamera as_mapped(*camera.value(), options.log_dir, recorded.log.masked);
      return map_source({as_mapped, *recorded.poses, std::move(notes), &recorded.log, recorded.poses->count()},
                        board.value(), mapping, command_line);
    }
  }
  auto poses = poses_or_start(options, board.value(), notes);
  if (!poses) return fail(poses.error().text);
  return map_source({*camera.value(), *poses.value(), std::move(notes)}, board.value(), mapping, command_line);
}

}  // namespace g3d
