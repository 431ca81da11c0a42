// SPDX-License-Identifier: Apache-2.0
// `g3dmap buses` and a robot whose board names stop devices, as a person who wires one up meets them. The bus and the
// lines come out of recordings: kernels that tests run on have neither.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

namespace {

constexpr const char* kWiredBoard = R"(name = "wired"
[can]
interface = "nocan7"
estop_node = 17
[gpio]
estop = "ESTOP"
)";

}  // namespace

TEST_CASE("recorded stop devices say again what they said", "[system][can][gpio]") {
  const TempFolder folder;
  write_plain(folder / "board.toml", kWiredBoard);
  write_plain(folder / "can.log",
              "(10.000000) can0 711#05\n(10.400000) can0 711#05\n(10.500000) can0 091#01FF010000000000\n"
              "(10.600000) can0 091#0000000000000000\n(10.700000) can0 711#05\n(12.000000) can0 3FF#\n");
  write_plain(folder / "gpio.log",
              "10000000000 ESTOP 1\n11000000000 ESTOP 0\n11100000000 ESTOP 1\n11500000000 OTHER 1\n");
  const ProgramResult said = run_g3dmap({"buses", "--board", folder / "board.toml", "--log", folder.path()});
  CHECK(said.err.empty());
  CHECK(said.exit_code == 0);
  CHECK(said.out ==
        "0.000 can go\n0.000 gpio not_yet\n0.050 gpio go\n0.500 can stop\n0.600 can go\n"
        "1.002 gpio stop\n1.150 gpio go\n1.202 can stop\n6 frames, 4 edges\n");
}

TEST_CASE("a recording that is none names file and line", "[system][can]") {
  const TempFolder folder;
  write_plain(folder / "board.toml", kWiredBoard);
  write_plain(folder / "can.log", "(10.000000) can0 711#05\nnonsense\n");
  const ProgramResult said = run_g3dmap({"buses", "--board", folder / "board.toml", "--log", folder.path()});
  CHECK(said.exit_code == 1);
  CHECK(said.err.find("can.log:2: ") != std::string::npos);
  const TempFolder empty;
  CHECK(run_g3dmap({"buses", "--board", folder / "board.toml", "--log", empty.path()}).exit_code == 1);
}

TEST_CASE("a board without stop devices, and a node that is none, are said to be so", "[system][can]") {
  CHECK(run_g3dmap({"buses", "--for", "1"}).exit_code == 1);
  CHECK(run_g3dmap({"buses", "--play-node", "can0"}).exit_code == 2);
  CHECK(run_g3dmap({"buses", "--play-node", "can0:128"}).exit_code == 2);
  const ProgramResult missing = run_g3dmap({"buses", "--play-node", "nocan7:17"});
  CHECK(missing.exit_code == 1);
  CHECK(missing.err.find("nocan7: ") != std::string::npos);
}

TEST_CASE("a robot whose stop node is not there stands, and says why", "[system][can]") {
  const TempFolder folder;
  write_plain(folder / "board.toml", kWiredBoard);
  const ProgramResult run =
      run_g3dmap({"run", "--board", folder / "board.toml", "--world", "house", "--camera", "80x60@10", "--resolution",
                  "0.1", "--duration", "4", "--record", folder / "log", "--quiet", "--out", folder / "out"});
  CHECK(run.exit_code == 0);
  CHECK(run.err.find("the robot stands until the CAN bus is there") != std::string::npos);
  const std::string report = folder / "out/report.json";
  CHECK(report_text(report, "interface") == "nocan7");
  CHECK(report_number(report, "failed_openings") >= 1);
  CHECK(report_number(report, "path_m") == 0.0);
  CHECK(std::filesystem::exists(folder / "log/can.log"));
}

TEST_CASE("a plan of threads that is none is refused", "[system][threads_plan]") {
  const TempFolder folder;
  write_plain(folder / "board.toml", "[threads]\nplan = \"base=loud\"\n");
  const ProgramResult run = run_g3dmap({"run", "--board", folder / "board.toml", "--duration", "1", "--quiet"});
  CHECK(run.exit_code == 1);
  CHECK(run.err.find("threads.plan: 'base=loud'") != std::string::npos);
}
