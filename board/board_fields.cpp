// SPDX-License-Identifier: Apache-2.0
#include "board/board_fields.hpp"

#include <fmt/format.h>

namespace g3d::board {

std::span<const BoardField> board_fields() {
  static const std::vector<BoardField> fields = {
      {"", "name", &Board::name, 0, 0, "", "what reports call this robot", {}},
      {"base",
       "line",
       &Board::base_line,
       0,
       0,
       "",
       "sim, auto (found by its USB strings), none or the port's path",
       {}},
      {"camera", "source", &Board::camera_source, 0, 0, "", "where live frames come from", {"sim", "none"}},
      {"camera", "width_px", &Board::camera_width_px, 16, 2048, "px", "image width", {}},
      {"camera", "height_px", &Board::camera_height_px, 16, 2048, "px", "image height", {}},
      {"camera", "fx_px", &Board::camera_fx_px, 10, 10000, "px", "focal length along the rows", {}},
      {"camera", "fy_px", &Board::camera_fy_px, 10, 10000, "px", "focal length along the columns", {}},
      {"camera", "cx_px", &Board::camera_cx_px, 0, 2047, "px", "column of the optical axis", {}},
      {"camera", "cy_px", &Board::camera_cy_px, 0, 2047, "px", "row of the optical axis", {}},
      {"camera",
       "depth_units_per_metre",
       &Board::camera_depth_units_per_metre,
       100,
       20000,
       "1/m",
       "raw depth of one metre",
       {}},
      {"camera", "rate_hz", &Board::camera_rate_hz, 1, 120, "Hz", "frames per second", {}},
      {"mount", "x_m", &Board::mount_x_m, -2, 2, "m", "camera in front of the base's centre", {}},
      {"mount", "y_m", &Board::mount_y_m, -2, 2, "m", "camera to the left of it", {}},
      {"mount", "z_m", &Board::mount_z_m, 0, 3, "m", "camera above the floor", {}},
      {"mount", "yaw_deg", &Board::mount_yaw_deg, -180, 180, "deg", "optical axis turned to the left", {}},
      {"mount", "pitch_deg", &Board::mount_pitch_deg, -90, 90, "deg", "optical axis raised", {}},
      {"mount", "roll_deg", &Board::mount_roll_deg, -180, 180, "deg", "image turned clockwise about the axis", {}},
      {"map", "resolution_m", &Board::map_resolution_m, 0.002, 1, "m", "edge of a voxel", {}},
      {"map", "near_m", &Board::map_near_m, 0.1, 10, "m", "nearest trusted depth", {}},
      {"map", "far_m", &Board::map_far_m, 0.2, 20, "m", "farthest trusted depth", {}},
      {"map", "hit", &Board::map_hit, 1, 16, "levels", "step up of a voxel that was hit", {}},
      {"map", "miss", &Board::map_miss, 1, 16, "levels", "step down of a voxel that was seen through", {}},
      {"map",
       "mode",
       &Board::map_mode,
       0,
       0,
       "",
       "register occupied voxels alone, or free ones too",
       {"static", "dynamic"}},
      {"map",
       "integrator",
       &Board::map_integrator,
       0,
       0,
       "",
       "how free space is found",
       {"dda", "bresenham", "projective"}},
      {"map", "memory_mb", &Board::map_memory_mb, 8, 65536, "MB", "memory for voxels, reserved at start", {}},
      {"map",
       "window_radius_m",
       &Board::map_window_radius_m,
       0,
       1000,
       "m",
       "kept in memory around the robot; 0: all",
       {}},
      {"map", "threads", &Board::map_threads, 1, 64, "", "threads of the mapper", {}},
      {"robot", "radius_m", &Board::robot_radius_m, 0.05, 2, "m", "of its footprint", {}},
      {"robot", "height_m", &Board::robot_height_m, 0.05, 3, "m", "", {}},
      {"ground", "low_m", &Board::ground_low_m, -1, 3, "m", "lowest height that blocks the way", {}},
      {"ground", "high_m", &Board::ground_high_m, -1, 3, "m", "highest height that blocks the way", {}},
      {"network", "key", &Board::network_key, 0, 0, "", "file of the fleet's key, or none", {}, kMaxLongTextBytes},
      {"network", "robot", &Board::network_robot, 0, 0, "", "its id in hexadecimal, or auto", {}},
      {"network", "port", &Board::network_port, 1, 65535, "", "UDP", {}},
      {"network", "group", &Board::network_group, 0, 0, "", "multicast address, or none", {}},
      {"network", "group_port", &Board::network_group_port, 1, 65535, "", "UDP port of the group", {}},
      {"network", "interface", &Board::network_interface, 0, 0, "", "that multicast goes through, or auto", {}},
      {"network", "peers", &Board::network_peers, 0, 0, "", "address:port,... or none", {}, kMaxLongTextBytes},
      {"network", "bandwidth_kBps", &Board::network_bandwidth_kBps, 2, 1e6, "kB/s", "what it may send", {}},
      {"network", "x_m", &Board::network_x_m, -1e5, 1e5, "m", "of its map's origin in the fleet's world", {}},
      {"network", "y_m", &Board::network_y_m, -1e5, 1e5, "m", "the same", {}},
      {"network", "yaw_deg", &Board::network_yaw_deg, -180, 180, "deg", "how its map is turned there", {}},
      {"network", "broker", &Board::network_broker, 0, 0, "", "address:port of an MQTT broker, or none", {}},
      {"network", "broker_topic", &Board::network_broker_topic, 0, 0, "", "what its topics begin with", {}},
      {"network", "broker_login", &Board::network_broker_login, 0, 0, "", "file, or none", {}, kMaxLongTextBytes},
      {"network",
       "broker_bandwidth_kBps",
       &Board::network_broker_bandwidth_kBps,
       2,
       1e6,
       "kB/s",
       "what it may send there",
       {}},
  };
  return fields;
}

std::string allowed_text(const BoardField& field) {
  if (!std::holds_alternative<std::string Board::*>(field.member)) {
    return fmt::format("{} to {}{}{}", field.low, field.high, field.unit.empty() ? "" : " ", field.unit);
  }
  if (field.choices.empty()) return fmt::format("a text of 1 to {} printable bytes", field.most_bytes);
  return fmt::format("{}", fmt::join(field.choices, ", "));
}

}  // namespace g3d::board
