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
  std::string base_line = "sim";  ///< "sim": a simulated building's; "auto": found by its USB strings; else the port

  // [camera] pinhole intrinsics of the depth image, colour registered to it
  std::string camera_source = "sim";  ///< of live frames: "sim", in the same building; "none": the base stands
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

  bool operator==(const Board&) const = default;
};

}  // namespace g3d::board
