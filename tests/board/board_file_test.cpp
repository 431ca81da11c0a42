// SPDX-License-Identifier: Apache-2.0
#include "board/board_file.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace g3d;
using board::Board;
using board::parse_board;
using Catch::Matchers::Contains;
using hal::Reason;

TEST_CASE("an empty board file is a board of defaults") {
  const auto parsed = parse_board("", "b.toml");
  REQUIRE(parsed);
  CHECK(parsed.value() == Board{});
}

TEST_CASE("a board file sets what it names and nothing else") {
  const auto parsed = parse_board(
      "name = \"r2\"\n[map]\nresolution_m = 0.02\nfar_m = 4\nthreads = 3\nmode = \"static\"\n[mount]\npitch_deg = "
      "-7.5\n",
      "b.toml");
  REQUIRE(parsed);
  Board expected;
  expected.name = "r2";
  expected.map_resolution_m = 0.02;
  expected.map_far_m = 4.0;
  expected.map_threads = 3;
  expected.map_mode = "static";
  expected.mount_pitch_deg = -7.5;
  CHECK(parsed.value() == expected);
}

TEST_CASE("a base's line is simulated, found, or named by its whole path") {
  CHECK(parse_board("", "b.toml").value().base_line == "sim");
  CHECK(parse_board("[base]\nline = \"auto\"\n", "b.toml").value().base_line == "auto");
  const auto named = parse_board("[base]\nline = \"/dev/ttyUSB0\"\n[camera]\nsource = \"none\"\n", "b.toml");
  REQUIRE(named);
  CHECK(named.value().base_line == "/dev/ttyUSB0");
  CHECK(named.value().camera_source == "none");
}

TEST_CASE("a fleet is named by its key, and peers by a list that may be long") {
  CHECK(parse_board("", "b.toml").value().network_key == "none");
  std::string peers = "10.0.0.1:7177";
  for (int i = 2; i < 40; ++i) peers += ",10.0.0." + std::to_string(i) + ":7177";
  const auto parsed = parse_board("[network]\nkey = \"fleet.key\"\nrobot = \"c0ffee\"\nport = 4711\npeers = \"" +
                                      peers + "\"\nx_m = -3.5\nyaw_deg = 90\n",
                                  "b.toml");
  REQUIRE(parsed);
  CHECK(parsed.value().network_key == "fleet.key");
  CHECK(parsed.value().network_robot == "c0ffee");
  CHECK(parsed.value().network_port == 4711);
  CHECK(parsed.value().network_peers == peers);
  CHECK(parsed.value().network_x_m == -3.5);
  CHECK(parsed.value().network_yaw_deg == 90.0);
  CHECK(parse_board(board::to_text(parsed.value()), "printed").value() == parsed.value());
}

TEST_CASE("the printed board reads back to the same board") {
  Board board;
  board.name = "odd one";
  board.map_resolution_m = 0.0123456789012345;
  board.camera_width_px = 320;
  board.camera_cx_px = 160.25;
  board.map_integrator = "dda";
  const auto parsed = parse_board(board::to_text(board), "printed");
  REQUIRE(parsed);
  CHECK(parsed.value() == board);
  CHECK_THAT(board::to_text(board), Contains("resolution_m = 0.0123456789012345") && Contains("0.002 to 1 m"));
}

TEST_CASE("errors of a board file name file, line and what is allowed") {
  struct Row {
    const char* text;
    Reason reason;
    const char* says;
  };
  const Row rows[] = {
      {"[map]\n\nresolution_m = 5\n", Reason::out_of_range,
       "b.toml:3: map.resolution_m is 5, allowed are 0.002 to 1 m"},
      {"[map]\nfar_m = nan\n", Reason::out_of_range, "b.toml:2: map.far_m is nan"},
      {"[map]\nnear_m = inf\n", Reason::out_of_range, "0.1 to 10 m"},
      {"[map]\nthreads = 9223372036854775807\n", Reason::out_of_range, "1 to 64"},
      {"[map]\nthreads = 2.5\n", Reason::malformed, "b.toml:2: map.threads must be a whole number"},
      {"[map]\nthreads = \"2\"\n", Reason::malformed, "must be a whole number"},
      {"[map]\nresolution_m = true\n", Reason::malformed, "must be a number"},
      {"[map]\nmode = \"both\"\n", Reason::out_of_range, "map.mode is both, allowed are static, dynamic"},
      {"[map]\nmode = 3\n", Reason::malformed, "a text in quotes"},
      {"[map]\nspeed = 3\n", Reason::malformed, "b.toml:2: map.speed is not known; here are resolution_m"},
      {"\n\n[mapp]\n", Reason::malformed, "b.toml:3: mapp is not known; here are name [base] [camera]"},
      {"map = 3\n", Reason::malformed, "map is not known"},
      {"name = \"a\"\n[map\n", Reason::malformed, "b.toml:2: "},
      {"name = \"a\"\ns\xEF\xBB\xBB", Reason::malformed, "b.toml:2: byte 0xEF; a board file is plain ASCII"},
      {"[.05\n", Reason::malformed, "b.toml:1: "},
      {"name = \"\"\n", Reason::out_of_range, "1 to 64 printable"},
      {"[map]\nnear_m = 4\n", Reason::out_of_range, "near_m must be below map.far_m"},
      {"[base]\nline = \"ttyUSB0\"\n", Reason::out_of_range, "b.toml: base.line must be sim, auto, none, or the whole"},
      {"[base]\nline = \"\"\n", Reason::out_of_range, "b.toml:2: base.line is "},
      {"[base]\nline = 3\n", Reason::malformed, "b.toml:2: base.line must be a text in quotes"},
      {"[network]\nport = 0\n", Reason::out_of_range, "b.toml:2: network.port is 0, allowed are 1 to 65535"},
      {"[network]\nkey = \"\"\n", Reason::out_of_range, "b.toml:2: network.key is "},
      {"[camera]\nsource = \"webcam\"\n", Reason::out_of_range, "camera.source is webcam, allowed are sim, none"},
      {"[camera]\nsource = \"oni:\"\n", Reason::out_of_range, "camera.source is oni:, allowed are sim, none"},
      {"[camera]\nsource = \"a.oni:b\"\n", Reason::out_of_range, "camera.source is a.oni:b"},
      {"[ground]\nlow_m = 1\n", Reason::out_of_range, "ground.low_m must be below"},
      {"[camera]\nwidth_px = 160\n", Reason::out_of_range, "within the image"},
      {"[map]\nwindow_radius_m = 2\n", Reason::out_of_range, "at least map.far_m"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.text);
    const auto parsed = parse_board(row.text, "b.toml");
    REQUIRE_FALSE(parsed.ok());
    CHECK(parsed.error().reason == row.reason);
    CHECK_THAT(parsed.error().text, Contains(row.says));
  }
}

TEST_CASE("a board file that is too long is refused before it is read") {
  const auto parsed = parse_board(std::string(300000, '#'), "b.toml");
  REQUIRE_FALSE(parsed.ok());
  CHECK(parsed.error().reason == Reason::too_large);
}

TEST_CASE("the boards that come with the program are good") {
  const auto host = board::load_board("board/host_sim.toml");
  REQUIRE(host);
  CHECK(host.value() == Board{});
  const auto station = board::load_board("board/base_station.toml");
  REQUIRE(station);
  CHECK(station.value().base_line == "none");
  CHECK(station.value().camera_source == "none");
  CHECK(station.value().network_key != "none");
  const auto kobuki = board::load_board("board/kobuki_tx2.toml");
  REQUIRE(kobuki);
  CHECK(kobuki.value().name == "kobuki_tx2");
  CHECK(kobuki.value().base_line == "auto");
  CHECK(kobuki.value().map_resolution_m == 0.02);
  CHECK(kobuki.value().map_window_radius_m == 15.0);
  CHECK(board::load_board("board/none.toml").error().reason == Reason::not_found);
}

TEST_CASE("a camera's stream is named by its place") {
  const auto board = parse_board("[base]\nline = \"auto\"\n[camera]\nsource = \"stream:/dev/virtio-ports/cam\"\n", "b");
  REQUIRE(board.ok());
  CHECK(board.value().camera_source == "stream:/dev/virtio-ports/cam");
  CHECK_FALSE(parse_board("[camera]\nsource = \"stream:\"\n", "b").ok());
  CHECK_FALSE(parse_board("[camera]\nsource = \"stream:PLACE\\\\\"\n", "b").ok());
  CHECK_FALSE(parse_board("[camera]\nsource = \"streams\"\n", "b").ok());
}
