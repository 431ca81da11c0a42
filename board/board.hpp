// SPDX-License-Identifier: Apache-2.0
// What differs from one robot to the next: one flat struct, every field with unit and default. The allowed ranges stand
// in board_fields.cpp, where the reader and the printed form find them. Known to main.cpp alone, which hands each part
// the few numbers that the part needs.
#pragma once

#include <string>

namespace g3d::board {

struct Board {
  std::string name = "host_sim";

  // [base] the Kobuki at the end of a serial line
  /// "sim": a simulated building's; "auto": found by its USB strings; "none": a base station; else the port
  std::string base_line = "sim";

  // [camera] pinhole intrinsics of the depth image, colour registered to it
  /// Of live frames: "sim", in the same building; "none": the base stands; "kinect": a Kinect 360, with a simulated
  /// base the virtual one; "oni:PLACE": a recording, PLACE is its file; "stream:PLACE": out of a byte stream, where
  /// PLACE is tcp:ADDRESS:PORT, or the path of a unix socket or of a device
  std::string camera_source = "sim";
  std::string camera_calibration = "none";  ///< of the Kinect: file, see hal/kinect/calibration.hpp; "none": typical
  int camera_width_px = 640;
  int camera_height_px = 480;
  double camera_fx_px = 525.0;
  double camera_fy_px = 525.0;
  double camera_cx_px = 319.5;
  double camera_cy_px = 239.5;
  double camera_depth_units_per_metre = 1000.0;
  double camera_rate_hz = 30.0;

  // [mount] the camera's place on the base (x forward, y left, z up from the floor) and where its optical axis points
  double mount_x_m = 0.0;
  double mount_y_m = 0.0;
  double mount_z_m = 0.5;
  double mount_yaw_deg = 0.0;
  double mount_pitch_deg = 0.0;  ///< elevation of the optical axis: -10 looks down
  double mount_roll_deg = 0.0;

  // [map]
  double map_resolution_m = 0.05;
  double map_near_m = 0.8;  ///< certainty bounds: depth z of a trusted reading
  double map_far_m = 3.5;
  int map_hit = 4;   ///< by how much a frame raises the level of a voxel it hit
  int map_miss = 2;  ///< by how much it lowers the level of one it saw through
  std::string map_mode = "dynamic";
  std::string map_integrator = "projective";
  int map_memory_mb = 512;           ///< budget of the voxel pools
  double map_window_radius_m = 0.0;  ///< blocks farther from the robot are paged out; 0: keep all
  int map_threads = 2;

  // [robot] its own footprint is taken as free at the start
  double robot_radius_m = 0.18;
  double robot_height_m = 0.6;

  // [ground] heights that block the robot: the band that ground.pgm is made from
  double ground_low_m = 0.05;
  double ground_high_m = 0.6;

  // [can] a CANopen bus (CiA 301) with an emergency-stop node
  std::string can_interface = "none";  ///< "can0"; "none": no bus
  double can_bitrate_kbps = 0.0;       ///< 0: somebody else brings the interface up
  int can_node = 10;                   ///< our own number on it
  int can_estop_node = 0;              ///< without it alive and operational the robot stands; 0: there is none
  double can_estop_heartbeat_ms = 500.0;
  std::string can_starts_estop = "no";  ///< be its network master: start it when it waits for one

  // [gpio] emergency-stop switch and lamp at lines of one chip, by name or number
  std::string gpio_chip = "none";
  std::string gpio_estop = "none";         ///< a contact that is normally closed
  std::string gpio_estop_second = "none";  ///< the switch's other contact, which is normally open
  std::string gpio_estop_closed = "high";  ///< level of the first line while the switch is not pressed
  double gpio_glitch_ms = 1.0;             ///< shorter openings are disturbances
  double gpio_release_ms = 50.0;           ///< closed for so long before it counts as released
  std::string gpio_bias = "as_is";
  std::string gpio_lamp = "none";

  // [watchdog] resets the machine unless every thread makes progress
  std::string watchdog_device = "none";  ///< "/dev/watchdog"
  int watchdog_timeout_s = 15;
  double watchdog_thread_s = 10.0;  ///< longest that a thread may work without a sign of life

  // [threads]
  std::string threads_plan = "none";  ///< "base=fifo40@5 *=@0,3,4": see hal/linux/thread_plan.hpp
  std::string threads_lock_memory = "no";

  // [network] the fleet that it shares its map with
  std::string network_key = "none";    ///< file with the fleet's key; "none": the robot is alone
  std::string network_robot = "auto";  ///< its id, 1 to 16 hexadecimal digits; "auto": from what the machine is called
  int network_port = 7177;             ///< UDP, what others answer to; where it is taken, any free one
  std::string network_group = "239.255.71.77";  ///< multicast, where robots find each other; "none": by peers alone
  int network_group_port = 7176;
  std::string network_interface = "auto";  ///< that multicast goes through; "auto": every one that is up
  std::string network_peers = "none";      ///< addresses to find besides: "10.0.0.2:7177,10.0.0.3:7177"
  double network_bandwidth_kBps = 250.0;   ///< what it may send
  std::string network_keep = "none";       ///< folder where the fleet's map survives a restart; "none": nowhere
  double network_x_m = 0.0;                ///< where its map's origin lies in the fleet's world ...
  double network_y_m = 0.0;
  double network_yaw_deg = 0.0;  ///< ... and how its x axis is turned there
  // ... and those of other sites, which a base station joins it with through an MQTT broker
  std::string network_broker = "none";           ///< "192.0.2.7:1883"
  std::string network_broker_topic = "g3dmap";   ///< what its topics begin with, the same at all sites
  std::string network_broker_login = "none";     ///< file with the lines "user NAME" and "password WORD"
  double network_broker_bandwidth_kBps = 100.0;  ///< what it may send there

  bool operator==(const Board&) const = default;
};

}  // namespace g3d::board
