// SPDX-License-Identifier: Apache-2.0
// What stands at the end of a command's --help: how people begin.
#pragma once

namespace g3d {

inline constexpr const char* kReplayExamples = R"(
Examples:
  g3dmap replay rgbd_dataset_freiburg1_rpy --out out
  g3dmap replay walk --poses odometry.tum --resolution 0.02 --threads 2 --out out
  g3dmap replay walk --odometry aligned --motion free --out out        poses that drift, from a hand-held camera
  g3dmap replay walk --rate 1 --out out          as fast as it was recorded; late frames are dropped and counted
  g3dmap replay eyes.oni --odometry none --out out       an OpenNI recording of a Kinect that stood, or with --poses

LOG is a folder in the TUM RGB-D layout: depth.txt, rgb.txt, groundtruth.txt or trajectory.tum, camera.txt. Without
poses they are computed from the base's bytes in kobuki.bin, with the camera mounted as --board says.)";

inline constexpr const char* kSimExamples = R"(
Examples:
  g3dmap sim --out out                                     a flight through the built-in furnished room
  g3dmap sim --drift 1 --odometry aligned --out out        the same flight with odometry that drifts, corrected
  g3dmap sim --world corridor --laps 2 --drift 1 --odometry aligned --loops --out out
  g3dmap sim --world house --robots 1 --seed 2 --out out   a robot explores a built-in house by itself
  g3dmap sim --world house --robots 3 --loss 0.2 --out out      three explore it together and share their maps
  g3dmap sim --world office.world --camera-path walk.path --resolution 0.02 --out out
  g3dmap sim --world house --robots 1 --drift 1 --odometry aligned --out out
  g3dmap sim --world floor.yaml --camera-path walk.path --out out     a map_server ground map, extruded to walls
  g3dmap sim --world floor.yaml --crop 0,0,30,20 --robots 1 --out out   a piece of a large one)";

inline constexpr const char* kRunExamples = R"(
Examples:
  g3dmap run --board board/host_sim.toml --out out                    in real time, in a simulated building
  g3dmap run --board board/host_sim.toml --world office --duration 60 --camera 160x120@10 --out out
  g3dmap run --board board/kobuki_tx2.toml --record log --out out     a real base; g3dmap replay log gives the same map
  g3dmap run --board board/host_sim.toml --key fleet.key --robot a1 --start 1 --out one      two robots of a fleet,
  g3dmap run --board board/host_sim.toml --key fleet.key --robot a2 --start 2 --out two      which share their maps,
  g3dmap run --board board/base_station.toml --key fleet.key --out all                       and who merges them

The first Ctrl-C stops the robot and saves the map, the second one ends the program at once; the base stands either way.)";

inline constexpr const char* kBuildingExamples = R"(
Examples:
  g3dmap building --world two_rooms --camera 160x120@10 --at place                     then, for robot 1, a board with
      base.line = "/.../place/robot1.base" and camera.source = "stream:/.../place/robot1.frames":
  g3dmap run --board that.toml --camera 160x120@10 --out out
  g3dmap building --base unix:kobuki.sock --frames listen:camera.sock --slow 4 --at place     for an emulated machine
  g3dmap tell place status                                 the outside truth: places, contacts, what cameras have seen
  g3dmap tell place stop                                   the same in place/truth.json)";

inline constexpr const char* kPeersExamples = R"(
Examples:
  g3dmap peers --at out                                    who knows what, as the program whose --out is `out` has it
  g3dmap peers --at out --json                             the same for scripts

Per robot: when it was heard last, and what it lacks of every layer of the shared map; and why datagrams were refused.)";

inline constexpr const char* kBusesExamples = R"(
Examples:
  g3dmap buses --board board/kobuki_tx2.toml               each change of what the stop switch and the CAN node say
  g3dmap buses --board board/kobuki_tx2.toml --log out     the same out of out/can.log and out/gpio.log
  g3dmap buses --make-vcan vcan0 --play-node vcan0:17      be emergency-stop node 17 on a virtual bus

Words: go; not_yet, until a device was seen well for the first time; stop, which a running robot keeps until a person
says resume. A played node takes lines: press, release, silence, speak, wait, quit.)";

inline constexpr const char* kTellExamples = R"(
Examples:
  g3dmap tell out pause                                    the robot whose --out is `out` stands, until resume
  g3dmap tell out status                                   one JSON object: state, coverage, way, battery, safety

pause, resume and stop take effect at once; stop outranks pause. home ends exploring and sends it home, or does so once
it is resumed. PATH is the folder of --out, or what --control named. Only the user who started the robot may speak to it.)";

inline constexpr const char* kExportExamples = R"(
Examples:
  g3dmap export out/map.g3d --to map.ply                   points with colours
  g3dmap export map.bt --to map.g3d --to map.pcd
  g3dmap export out/map.g3d --to ground.yaml               also writes ground.pgm

The endings choose the format: .g3d .ot .bt .ply .pcd .yaml (ground map) .png (picture).)";

inline constexpr const char* kInfoExamples = R"(
Examples:
  g3dmap info out/map.g3d
  g3dmap info map.bt --json)";

inline constexpr const char* kMergeExamples = R"(
Examples:
  g3dmap merge a.g3d b.g3d --out both.g3d                  each map at the pose that its file states
  g3dmap merge a.g3d b.g3d --pose 0,0,0,0,0,0 --pose 2.5,0,0,0,0,1.5708 --out both.g3d
  g3dmap merge a.g3d b.g3d --align rough --out both.g3d    poses that are up to 1 m and 30 degrees off

A pose is x,y,z in metres and roll,pitch,yaw in radians, one --pose per map in the same order.)";

inline constexpr const char* kMaskExamples = R"(
Example:
  g3dmap mask wall_view --out mask.png                     then: g3dmap replay walk --mask mask.png --out out

LOG is a recording of a plain wall that fills the view.)";

inline constexpr const char* kDriftExamples = R"(
Example:
  g3dmap drift walk --seed 3 --out odometry.tum
  g3dmap replay walk --poses odometry.tum --odometry aligned --out out

POSES is a recording, or a file of poses in TUM's format.)";

inline constexpr const char* kKeyExamples = R"(
Examples:
  g3dmap key --out fleet.key                               a new fleet; copy the file to every robot, mode 0600
  g3dmap key --show fleet.key                              epoch, fingerprint, who is revoked; never the key
  g3dmap key --rotate fleet.key                            a new key; robots with the old one are heard until --finish
  g3dmap key --finish fleet.key                            every robot has the new key: the old one is worth nothing
  g3dmap key --rotate --shut-out fleet.key                 a robot is in wrong hands: nobody listens to the old key
  g3dmap key --revoke 00c0ffee fleet.key                   nobody takes what this robot says any more
  g3dmap key --drop 00c0ffee fleet.key                     the same, and nobody keeps what it has mapped

Whoever has the key can speak as any robot, so only --shut-out keeps out somebody who has read it.)";

}  // namespace g3d
