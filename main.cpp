// SPDX-License-Identifier: Apache-2.0
// g3dmap's command line and nothing else: what may be said, within which limits, and who does it.
#include <CLI/CLI.hpp>
#include <string>

#include "main_commands.hpp"
#include "main_examples.hpp"
#include "main_init.hpp"
#include "main_update.hpp"
#include "mapper/version.hpp"

namespace {

using namespace g3d;

void add_staging_options(CLI::App& command, StagingOptions& staging) {
  command.add_option("--control", staging.control, "Socket for `g3dmap tell`; default: control in the folder of --out");
  command.add_option("--at", staging.at, "SECONDS:WORD, such as 20:pause; may be given several times")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--fail", staging.fail,
                  "What goes wrong: PART:KIND@FROM+SECONDS, such as camera:stuck@20+5; PART camera, odometry, line or "
                  "disk, KIND off, stuck, garbage, wrong, slow, delayed or intermittent")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--battery", staging.battery_min, "The simulated battery is empty after so many minutes")
      ->check(CLI::Range(0.1, 10000.0));
}

void add_patience(CLI::App& command, MappingOptions& options) {
  command.add_option("--patience", options.patience_s, "Try files that the disk refuses again for so many seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
}

void add_mapper_option(CLI::App& command, MappingOptions& options) {
  command.add_option("--mapper", options.mapper, "Where the map is computed; auto: by an NVIDIA card if there is one")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
}

void add_loops_flag(CLI::App& command, MappingOptions& options) {
  command.add_flag("--loops", options.loops,
                   "Recognise places that are seen again and correct the whole map by them; needs --odometry aligned");
}

void add_odometry_options(CLI::App& command, MappingOptions& options) {
  command
      .add_option(
          "--odometry", options.odometry,
          "given: poses as they come; aligned: each corrected by what its frame shows; none: by the frames alone")
      ->check(CLI::IsMember({"given", "aligned", "none"}))
      ->capture_default_str();
  command
      .add_option("--motion", options.motion,
                  "How the camera may move when it is aligned: planar on a robot, free in a hand")
      ->check(CLI::IsMember({"planar", "free"}));
  add_loops_flag(command, options);
}

void add_drift_like(CLI::App& command, std::string& drift_like) {
  command
      .add_option(
          "--drift-like", drift_like,
          "What drifts in robots: kobuki, a real base; rough, as flights do, 2 % of the way and 0.5 degrees per "
          "root second")
      ->check(CLI::IsMember({"kobuki", "rough"}))
      ->capture_default_str();
}

void add_network_options(CLI::App& command, LiveOptions& live) {
  NetworkOptions& network = live.network;
  command.add_option("--key", network.key, "File of the fleet's key: it shares its map with the fleet; or none");
  command.add_option("--robot", network.robot, "Its id in the fleet, in hexadecimal; auto: from the machine's");
  command.add_option("--port", network.port, "UDP port that other robots answer to")->check(CLI::Range(1, 65535));
  command
      .add_option("--peer", network.peers, "ADDRESS:PORT of another robot, where multicast does not go; several times")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--keep", network.keep, "Folder where the layers of the fleet's map survive a restart; or none");
  command
      .add_option("--settle", network.settle_s, "At the end, tell others what they lack for so many seconds at most")
      ->check(CLI::Range(0.0, 1e6));
  command.add_option("--checkpoint", live.mapping.checkpoint_s, "A base station saves its map every so many seconds")
      ->check(CLI::Range(0.0, 1e6));
  command.add_option("--start", live.start, "Where in the simulated building: 1 to 16, or X,Y,DEGREES");
}

void add_live_options(CLI::App& command, LiveOptions& live) {
  MappingOptions& options = live.mapping;
  add_mapper_option(command, options);
  command.add_option("--board", options.board_path, "Board file (toml): which base, which camera")->required();
  command.add_option("--out", options.out_dir, "Folder for map, trajectory and report; without it nothing is written");
  command.add_option("--world", live.world, "The simulated building: built-in name, world file or map_server yaml")
      ->capture_default_str();
  command.add_option("--duration", live.duration_s, "Stop after so many seconds; 0: when the robot is home again")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command.add_option("--seed", options.seed, "Seed of everything random")->capture_default_str();
  command.add_option("--camera", live.camera,
                     "The simulated camera as WIDTHxHEIGHT@HZ, such as 160x120@10; also of a stream");
  command.add_option("--drift", live.drift, "How wrong the simulated odometry is: 0 exact, 1 like a real base")
      ->check(CLI::Range(0.0, 10.0));
  add_drift_like(command, live.drift_like);
  command.add_option("--area", live.area, "Explore only X0,Y0,X1,Y1 in metres");
  command.add_option("--odometry", options.odometry, "given: odometry is believed; aligned: corrected by what is seen")
      ->check(CLI::IsMember({"given", "aligned"}))
      ->capture_default_str();
  add_loops_flag(command, options);
  add_staging_options(command, live.staging);
  add_patience(command, options);
  command.add_option("--slow", live.slow, "Its clock goes so many times slower, as that of its `g3dmap building`")
      ->check(CLI::Range(1.0, 100.0));
  command.add_option("--record", live.record, "New folder for frames, poses and what the base says, for replay");
  command.add_option("--record-oni", live.oni_path, "Record what the Kinect sees into this .oni file");
  command.add_flag("--await-base", live.await_base, "Start without the base as well, and wait until it is plugged in");
  command.add_option("--resolution", options.resolution_m, "Edge of a voxel in metres")->check(CLI::Range(0.002, 1.0));
  command.add_option("--threads", options.threads, "Threads of the mapper")->check(CLI::Range(1, 64));
  command.add_option("--memory", options.memory_mb, "Limit of the map's memory in MB")->check(CLI::Range(16, 1 << 20));
  command.add_flag("--no-colour", options.no_colour, "Keep occupancy only");
  command.add_flag("--no-noise", live.no_noise, "A perfect simulated sensor");
  command.add_flag("--quiet", options.quiet, "No progress and no summary");
  command.add_flag("--json", options.json, "Print report.json instead of the summary");
}

void add_mapping_options(CLI::App& command, MappingOptions& options) {
  command.add_option("--out", options.out_dir, "Folder for what is made; it is created if need be")->required();
  command.add_option("--board", options.board_path, "Board file (toml); it gives the defaults of what follows");
  command.add_option("--resolution", options.resolution_m, "Edge of a voxel in metres")->check(CLI::Range(0.002, 1.0));
  command.add_option("--integrator", options.integrator, "How free space is found")
      ->check(CLI::IsMember({"dda", "bresenham", "projective"}));
  command.add_option("--mode", options.mode, "static keeps occupied voxels only")
      ->check(CLI::IsMember({"static", "dynamic"}));
  add_mapper_option(command, options);
  command.add_option("--threads", options.threads, "Threads of the mapper; the map is the same for any number")
      ->check(CLI::Range(1, 64));
  command.add_option("--rate", options.rate, "Real time, this many times as fast as recorded; 0: as fast as possible")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  command.add_option("--memory", options.memory_mb, "Limit of the map's memory in MB")->check(CLI::Range(16, 1 << 20));
  command.add_option("--window", options.window_m, "Keep what is farther than this many metres on disk; 0: nothing")
      ->check(CLI::Range(0.0, 1000.0));
  command.add_option("--footprint", options.footprint,
                     "The robot's cylinder RADIUS,HEIGHT in metres, or 'board': free where it starts");
  command.add_option("--checkpoint", options.checkpoint_s, "Save map.g3d every so many seconds as well; 0: at the end")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command.add_option("--mask", options.mask_path, "Free scan mask, a picture made by g3dmap mask");
  command.add_option("--seed", options.seed, "Seed of everything random")->capture_default_str();
  command.add_flag("--no-colour", options.no_colour, "Keep occupancy only");
  command.add_flag("--quiet", options.quiet, "No progress and no summary");
  command.add_flag("--json", options.json, "Print report.json instead of the summary");
}

void add_building_options(CLI::App& command, BuildingOptions& building) {
  MappingOptions& options = building.mapping;
  const auto several = [&command](const char* name, std::vector<std::string>& into, const char* what) {
    command.add_option(name, into, what)->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  };
  command.add_option("--world", building.world, "Built-in name, world file or map_server yaml")->capture_default_str();
  command.add_option("--crop", building.crop, "Take only X0,Y0,X1,Y1 of a map_server map");
  command.add_option("--board", options.board_path, "Board file of the robots: mounting and size; default: host_sim");
  command.add_option("--robots", building.robots, "How many there are")->check(CLI::Range(1, 16));
  several("--start", building.starts, "X,Y,DEGREES of a robot; once for each, or not at all");
  command.add_option("--at", building.at, "Folder for control socket, truth.json, and sockets not named otherwise");
  several("--base", building.bases,
          "Serial line of a robot: pty:LINK, unix:PATH (dials it again and again) or "
          "listen:PATH; once for each");
  several("--frames", building.frames,
          "Camera of a robot: listen:PATH, listen:tcp:ADDRESS:PORT, or without listen: to "
          "dial; once for each");
  command.add_option("--camera", building.camera, "The cameras as WIDTHxHEIGHT@HZ, such as 160x120@5");
  command.add_option("--duration", building.duration_s, "Stop after so many of its seconds; 0: when it is told to")
      ->check(CLI::Range(0.0, 1e6));
  command.add_option("--slow", building.slow, "So many seconds pass in one of its own; robots need the same")
      ->check(CLI::Range(1.0, 100.0));
  command.add_option("--seed", options.seed, "Seed of everything random")->capture_default_str();
  command.add_option("--drift", building.drift, "How wrong the odometry is: 0 exact, 1 like a real base")
      ->check(CLI::Range(0.0, 10.0));
  add_drift_like(command, building.drift_like);
  command.add_option("--control", building.staging.control, "Socket for `g3dmap tell`; default: control in --at");
  several("--fail", building.staging.fail, "What goes wrong: PART:KIND@FROM+SECONDS, as for run");
  command.add_option("--battery", building.staging.battery_min, "The batteries are empty after so many minutes")
      ->check(CLI::Range(0.1, 10000.0));
  command.add_flag("--no-noise", building.no_noise, "Perfect sensors");
  command.add_flag("--quiet", options.quiet, "Say nothing");
  command.add_flag("--json", options.json, "Print truth.json at the end");
}

CLI::App* add_command(CLI::App& app, const char* name, const char* what, const char* examples) {
  CLI::App* command = app.add_subcommand(name, what);
  command->footer(examples);
  return command;
}

/// The command as it was typed, quoted where a shell needs it: for report.json.
std::string command_line(int argc, char** argv) {
  std::string line;
  for (int i = 0; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = !word.empty() && word.find_first_of(" \t\n'\"\\$`*?&|;<>()") == std::string::npos;
    line += (i > 0 ? " " : "") + (plain ? word : "'" + word + "'");
  }
  return line;
}

int parse_and_run(int argc, char** argv) {
  CLI::App app{"g3dmap: depth frames in, coloured 3D occupancy map out.\n"};
  app.set_version_flag("--version", std::string("g3dmap ") + mapper::version());
  app.require_subcommand(1);
  app.footer("\n'g3dmap COMMAND --help' shows the options and examples of one command.");

  ReplayOptions replay;
  CLI::App* replay_command = add_command(app, "replay", "Map a recorded walk", kReplayExamples);
  replay_command->add_option("LOG", replay.log_dir, "Folder of the recording")->required();
  replay_command->add_option("--poses", replay.poses_path, "Poses T_world_camera, TUM format");
  add_mapping_options(*replay_command, replay.mapping);
  add_odometry_options(*replay_command, replay.mapping);

  SimOptions sim;
  CLI::App* sim_command =
      add_command(app, "sim", "Fly a simulated Kinect through a world, or let a robot explore it", kSimExamples);
  sim_command->add_option("--world", sim.world, "World file, map_server yaml, or builtin")->capture_default_str();
  sim_command->add_option("--camera-path", sim.camera_path, "Way of the camera, or builtin")->capture_default_str();
  sim_command->add_option("--laps", sim.laps, "Fly the way so many times")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sim_command
      ->add_option("--duration", sim.duration_s,
                   "Stop after so many simulated seconds; 0: where the path ends, or robots are home")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  sim_command->add_option("--fps", sim.frame_rate_hz, "Frames per simulated second; default: the board's")
      ->check(CLI::Range(0.1, 240.0));
  sim_command
      ->add_option("--robots", sim.robots, "Robots that explore the world by themselves, instead of a camera path")
      ->check(CLI::Range(1, 16));
  sim_command->add_option("--loss", sim.loss, "Share of what robots send each other that the radio loses")
      ->check(CLI::Range(0.0, 0.95));
  sim_command
      ->add_option("--radio-range", sim.radio_range_m, "How far robots hear each other, in metres; 0: everywhere")
      ->check(CLI::Range(0.0, 100000.0));
  sim_command->add_option("--radio-rate", sim.radio_Bps, "Bytes per second that each robot may send")
      ->check(CLI::Range(2000.0, 1e9));
  sim_command->add_option("--partition", sim.cuts,
                          "FROM-TO:1,2|3,4: from second FROM to TO robots hear their own group alone");
  sim_command->add_option("--kill", sim.deaths, "ROBOT@SECONDS: it dies then, and stands where it stood");
  sim_command->add_option("--camera", sim.camera, "The robots' cameras as WIDTHxHEIGHT@HZ, such as 160x120@10");
  sim_command->add_option("--drift", sim.drift, "How wrong odometry is: 0 exact, 1 like a real base")
      ->check(CLI::Range(0.0, 10.0));
  add_drift_like(*sim_command, sim.drift_like);
  sim_command->add_option("--area", sim.area, "Explore only X0,Y0,X1,Y1 in metres");
  sim_command->add_option("--crop", sim.crop,
                          "Take only X0,Y0,X1,Y1 of a map_server map, in metres of the map; the cut is a wall");
  sim_command->add_flag("--no-noise", sim.no_noise, "A perfect sensor");
  add_staging_options(*sim_command, sim.staging);
  add_patience(*sim_command, sim.mapping);
  add_mapping_options(*sim_command, sim.mapping);
  add_odometry_options(*sim_command, sim.mapping);

  LiveOptions live;
  CLI::App* run_command =
      add_command(app, "run", "Let the board's robot explore where it stands, in real time", kRunExamples);
  add_live_options(*run_command, live);
  add_network_options(*run_command, live);

  BuildingOptions building;
  CLI::App* building_command = add_command(
      app, "building", "Run a simulated building for robots in other programs or machines", kBuildingExamples);
  add_building_options(*building_command, building);

  TellOptions tell;
  CLI::App* tell_command = add_command(app, "tell", "Speak to a robot that runs", kTellExamples);
  tell_command->add_option("PATH", tell.path, "Its folder, or its socket")->required();
  tell_command->add_option("WORD", tell.word, "What to say")
      ->required()
      ->check(CLI::IsMember({"pause", "resume", "stop", "home", "status", "buses"}));

  PeersOptions peers;
  CLI::App* peers_command = add_command(app, "peers", "Say who knows what in a fleet", kPeersExamples);
  peers_command->add_option("--at", peers.path, "The folder of the program that is asked, or its socket")
      ->default_val("out");
  peers_command->add_flag("--json", peers.json, "For scripts");

  BusesOptions buses;
  CLI::App* buses_command = add_command(app, "buses", "Say what a robot's stop devices say", kBusesExamples);
  buses_command->add_option("--board", buses.board_path, "Board file");
  buses_command->add_option("--for", buses.for_s, "End after so many seconds")->check(CLI::Range(0.1, 1e6));
  buses_command->add_option("--record", buses.record_dir, "Folder for can.log and gpio.log");
  buses_command->add_option("--log", buses.log_dir, "Say what a recording says instead");
  buses_command->add_option("--play-node", buses.play_node, "INTERFACE:NODE: be that emergency-stop node instead");
  buses_command->add_flag("--waits", buses.waits, "The played node waits for a network master");
  buses_command->add_option("--make-vcan", buses.make_vcan, "Make this virtual CAN interface first (as root)");
  buses_command->add_flag("--json", buses.json, "One JSON object with all counters at the end");

  ExportOptions exported;
  CLI::App* export_command = add_command(app, "export", "Write a map in other formats", kExportExamples);
  export_command->add_option("MAP", exported.from, "map.g3d, .ot or .bt")->required();
  export_command->add_option("--to", exported.to, "File to write; may be given several times")->required();

  InfoOptions info;
  CLI::App* info_command = add_command(app, "info", "Say what is in a map", kInfoExamples);
  info_command->add_option("FILE", info.file, "map.g3d, .ot or .bt")->required();
  info_command->add_flag("--json", info.json, "For scripts");

  MergeOptions merge;
  CLI::App* merge_command =
      add_command(app, "merge", "Join maps, at their poses or aligned to each other", kMergeExamples);
  merge_command->add_option("MAPS", merge.maps, "Maps to join")->required()->expected(1, 256);
  merge_command->add_option("--pose", merge.poses, "x,y,z,roll,pitch,yaw of one map, in the order of the maps")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  merge_command
      ->add_option("--align", merge.align,
                   "Fit each map to those before it: its pose is known (0.3 m, 6 degrees), rough (1 m, 30 degrees) or "
                   "unknown; refused where the maps do not say it clearly")
      ->check(CLI::IsMember({"known", "rough", "unknown"}));
  merge_command->add_option("--out", merge.out, "Map to write")->required();

  MaskOptions mask;
  CLI::App* mask_command = add_command(app, "mask", "Make a free scan mask from a recorded wall view", kMaskExamples);
  mask_command->add_option("LOG", mask.log_dir, "Folder of the recording")->required();
  mask_command->add_option("--out", mask.out, "16-bit PNG to write")->required();

  DriftOptions drift;
  CLI::App* drift_command = add_command(app, "drift", "Make poses drift as odometry does", kDriftExamples);
  drift_command->add_option("POSES", drift.poses, "Recording, or file of poses")->required();
  drift_command->add_option("--motion", drift.motion, "planar: a robot on wheels; free: a hand-held camera")
      ->check(CLI::IsMember({"planar", "free"}))
      ->capture_default_str();
  drift_command->add_option("--seed", drift.seed, "Which drift")->capture_default_str();
  drift_command->add_option("--out", drift.out, "File of poses to write")->required();

  KeyOptions key;
  CLI::App* key_command = add_command(app, "key", "Make or change the key that makes robots one fleet", kKeyExamples);
  key_command->add_option("FILE", key.file, "The fleet's key");
  key_command->add_option("--out", key.out, "Make a new fleet's key; refused if the file is there");
  key_command->add_flag("--rotate", key.rotate, "A new key for the next epoch; the old one is heard until --finish");
  key_command->add_flag("--shut-out", key.shut_out, "With --rotate: nobody listens to the old key any more");
  key_command->add_flag("--finish", key.finish, "Every robot has the new key: forget the old one");
  key_command->add_option("--revoke", key.revoke, "Robot that nobody listens to any more, in hexadecimal");
  key_command->add_option("--drop", key.drop, "The same, of a robot whose layers are thrown away as well");
  key_command->add_flag("--show", key.show, "Say what is in it, but for the key");

  UpdateOptions update;
  add_update_options(
      *add_command(app, "update", "Put a new system on a robot, signed and over the network", kUpdateExamples), update);
  SlotsOptions slots;
  add_slots_options(*add_command(app, "slots", "Say which systems a machine holds", kSlotsExamples), slots);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitDone : kExitBadUsage;
  }
  if (*replay_command) return run_replay(replay, command_line(argc, argv));
  if (*sim_command) {
    const auto run = sim.robots > 1 ? run_team : sim.robots == 1 ? run_explore : run_sim;
    return run(sim, command_line(argc, argv));
  }
  if (*run_command) return run_live(live, command_line(argc, argv));
  if (*building_command) return run_building(building);
  if (*tell_command) return run_tell(tell);
  if (*peers_command) return run_peers(peers);
  if (*buses_command) return run_buses(buses);
  if (*export_command) return run_export(exported);
  if (*info_command) return run_info(info);
  if (*merge_command) return run_merge(merge);
  if (*drift_command) return run_drift(drift);
  if (*key_command) return run_key(key);
  if (app.got_subcommand("update")) return run_update(update);
  if (app.got_subcommand("slots")) return run_slots(slots);
  return run_mask(mask);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (is_first_process(argv[0])) return run_init();
    return parse_and_run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("g3dmap: out of memory; a smaller --memory or a coarser --resolution needs less\n", stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "g3dmap: %s\n", error.what());
  }
  return kExitFailed;
}
