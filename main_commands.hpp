// SPDX-License-Identifier: Apache-2.0
// What the command line says, as plain values, and the functions that do it. Each returns the process's exit code:
// 0 done, 1 failed at run time, 2 bad usage.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace g3d {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitBadUsage = 2;

/// Options that mean the same for every command that maps. What is not given comes from the board.
struct MappingOptions {
  std::string out_dir;
  std::string board_path;  ///< empty: the built-in host_sim
  std::string mask_path;   ///< empty: free scan mask from the intrinsics
  std::optional<std::string> integrator;
  std::optional<std::string> mode;
  std::optional<double> resolution_m;
  std::optional<int> threads;
  std::optional<int> memory_mb;    ///< what the map may grow to
  std::optional<double> window_m;  ///< what is farther from the camera is paged out; 0: nothing
  std::string footprint;           ///< "RADIUS,HEIGHT" in metres, or "board"; empty: nothing is taken as free
  double checkpoint_s = 0.0;       ///< save map.g3d this often while mapping; 0: at the end only
  double patience_s = 30.0;        ///< a robot's files that the disk refuses are tried again for so long
  std::string mapper = "auto";
  std::uint64_t seed = 1;
  double rate = 0.0;                  ///< 0: lockstep
  std::string odometry = "given";     ///< given, aligned or none
  std::optional<std::string> motion;  ///< planar or free; none: as the command has it
  bool loops = false;                 ///< correct the whole map where a place is recognised
  bool no_colour = false;
  bool quiet = false;
  bool json = false;
};

/// What happens to a robot while it runs.
struct StagingOptions {
  std::string control;            ///< socket for people's words; empty: "control" in the folder of --out
  std::vector<std::string> at;    ///< "SECONDS:WORD": words that a script says
  std::vector<std::string> fail;  ///< "PART:KIND@FROM+SECONDS": what goes wrong
  double battery_min = 0.0;       ///< a simulated battery is empty after so many minutes; 0: as a Kobuki's
};

struct ReplayOptions {
  MappingOptions mapping;
  std::string log_dir;
  std::string poses_path;  ///< empty: trajectory.tum, else groundtruth.txt, else odometry from kobuki.bin
};

struct SimOptions {
  MappingOptions mapping;
  std::string world = "builtin";  ///< our world file, a map_server yaml, or builtin
  std::string camera_path = "builtin";
  int laps = 1;                         ///< how often the path is flown
  double duration_s = 0.0;              ///< 0: to the end of the path
  std::optional<double> frame_rate_hz;  ///< none: the board camera's
  bool no_noise = false;
  StagingOptions staging;
  int robots = 0;                     ///< above 0: they drive themselves, and there is no camera path
  double loss = 0.0;                  ///< share of datagrams between robots that the radio loses
  double radio_range_m = 0.0;         ///< how far robots hear each other; 0: everywhere
  double radio_Bps = 250'000.0;       ///< what each may send
  std::vector<std::string> cuts;      ///< "FROM-TO:1,2|3": groups of robots that do not hear each other
  std::vector<std::string> deaths;    ///< "ROBOT@SECONDS"
  std::string camera;                 ///< "WxH@HZ" of the robots' cameras; empty: the board's
  double drift = 0.0;                 ///< how wrong odometry is; 1 is a typical base
  std::string drift_like = "kobuki";  ///< of robots: "kobuki" or "rough"
  std::string area;                   ///< "X0,Y0,X1,Y1": explore nothing outside of it; empty: everywhere
  std::string crop;  ///< "X0,Y0,X1,Y1": the piece of a map_server map that is the world; empty: all of it
};

/// The fleet that a program takes part in, instead of what the board says.
struct NetworkOptions {
  std::optional<std::string> key;    ///< file, or none
  std::optional<std::string> robot;  ///< hexadecimal, or auto
  std::optional<int> port;
  std::vector<std::string> peers;   ///< "10.0.0.2:7177"
  std::optional<std::string> keep;  ///< folder for what is to survive a restart, or none
  std::optional<double> settle_s;   ///< at the end others are told what they lack for so long at most
};

struct LiveOptions {
  MappingOptions mapping;  ///< out_dir may be empty: nothing is written
  NetworkOptions network;
  std::string start;            ///< in a simulated building: "2", or "X,Y,DEGREES"; empty: the first
  std::string world = "house";  ///< of the simulated building, if the board's base is in one
  double duration_s = 0.0;      ///< 0: until it is home again
  std::string camera;           ///< "WxH@HZ" of the simulated camera; empty: the board's
  std::string area;             ///< "X0,Y0,X1,Y1": explore nothing outside of it; empty: everywhere
  double drift = 0.0;           ///< how wrong the simulated base's odometry is
  std::string drift_like = "kobuki";
  bool no_noise = false;
  double slow = 1.0;        ///< its clock: so many seconds pass in one of its own; only with the camera of a building
  std::string record;       ///< folder for frames, poses and the base's bytes; empty: nothing is recorded
  std::string oni_path;     ///< what a Kinect sees is recorded there; empty: nowhere
  bool await_base = false;  ///< a base that is not there yet is no error
  StagingOptions staging;
};

/// A simulated building for robots in other programs or machines.
struct BuildingOptions {
  MappingOptions mapping;  ///< board, seed, quiet and json alone: where the cameras are mounted and what they are
  std::string world = "house";
  std::string crop;                 ///< as for sim
  int robots = 1;                   ///< at least so many
  std::vector<std::string> starts;  ///< "X,Y,DEGREES" of each robot; none: the world's own
  std::string at;                   ///< folder for the control socket, truth.json and what is not named otherwise
  std::vector<std::string> bases;   ///< of each robot: "pty:LINK", "unix:PATH", "tcp:ADDRESS:PORT" or "listen:" and one
  std::vector<std::string> frames;  ///< of each robot's camera: the same but for terminals
  std::string camera;               ///< "WxH@HZ"; empty: the board's
  double duration_s = 0.0;          ///< of its own time; 0: until somebody stops it
  double slow = 1.0;                ///< so many seconds pass in one of its own
  double drift = 0.0;
  std::string drift_like = "kobuki";
  bool no_noise = false;
  StagingOptions staging;  ///< but for words
};

struct TellOptions {
  std::string path;  ///< the robot's folder, or its socket
  std::string word;
};

struct PeersOptions {
  std::string path;  ///< the program's folder, or its socket
  bool json = false;
};

struct BusesOptions {
  std::string board_path;  ///< whose stop devices are asked; empty: the built-in host_sim, which has none
  double for_s = 0.0;      ///< 0: until it is told to end
  std::string record_dir;  ///< can.log and gpio.log; empty: nowhere
  std::string log_dir;     ///< say what was recorded there instead
  std::string play_node;   ///< "can0:17": be that emergency-stop node instead
  bool waits = false;      ///< the played node waits for a network master
  std::string make_vcan;   ///< make this virtual CAN interface first
  bool json = false;
};

struct ExportOptions {
  std::string from;
  std::vector<std::string> to;
};

struct InfoOptions {
  std::string file;
  bool json = false;
};

struct MergeOptions {
  std::vector<std::string> maps;
  std::vector<std::string> poses;  ///< "x,y,z,roll,pitch,yaw" per map, or none at all
  std::string align;               ///< how well the poses are known: known, rough or unknown; empty: exactly
  std::string out;
};

struct MaskOptions {
  std::string log_dir;
  std::string out;
};

struct DriftOptions {
  std::string poses;  ///< TUM file, or folder of a recording
  std::string motion = "planar";
  std::uint64_t seed = 1;
  std::string out;
};

struct KeyOptions {
  std::string out;   ///< file to make
  std::string file;  ///< file that is there, for all that follows
  bool rotate = false;
  bool shut_out = false;
  bool finish = false;
  std::string revoke;  ///< a robot's id, hexadecimal
  std::string drop;    ///< the same, of a robot whose layers go as well
  bool show = false;
};

int run_replay(const ReplayOptions& options, const std::string& command_line);
int run_sim(const SimOptions& options, const std::string& command_line);
/// `sim --robots 1`.
int run_explore(const SimOptions& options, const std::string& command_line);
/// `sim --robots N` with more of them.
int run_team(const SimOptions& options, const std::string& command_line);
/// `run`.
int run_live(const LiveOptions& options, const std::string& command_line);
/// The same for a board without base and camera.
int run_station(const LiveOptions& options, const std::string& command_line);
/// `building`.
int run_building(const BuildingOptions& options);
int run_tell(const TellOptions& options);
int run_buses(const BusesOptions& options);
int run_peers(const PeersOptions& options);
int run_export(const ExportOptions& options);
int run_info(const InfoOptions& options);
int run_merge(const MergeOptions& options);
int run_mask(const MaskOptions& options);
int run_drift(const DriftOptions& options);
int run_key(const KeyOptions& options);

}  // namespace g3d
