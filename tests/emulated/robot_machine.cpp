// SPDX-License-Identifier: Apache-2.0
#include "tests/emulated/robot_machine.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace g3d::test {
namespace {

constexpr std::uint64_t kSector_bytes = 512;

std::string image_folder() {
  const char* const named = std::getenv("G3DMAP_IMAGE");
  return named != nullptr ? named : "build/emulated/image";
}

void run_tool(const std::string& program, const std::vector<std::string>& arguments) {
  Program tool(program, arguments);
  const ProgramResult result = tool.finish();
  if (result.exit_code != 0) throw std::runtime_error(program + ": " + result.err);
}

double number_after(const std::string& json, const std::string& key) {
  const std::size_t at = json.find("\"" + key + "\":");
  if (at == std::string::npos) return std::nan("");
  return std::strtod(json.c_str() + at + key.size() + 3, nullptr);
}

}  // namespace

std::string no_robot_machine() {
  if (const std::string missing = Machine::what_is_missing(); !missing.empty()) return missing;
  if (!std::filesystem::exists(image_folder() + "/disk.img"))
    return image_folder() + "/disk.img is not there; make emulated makes it";
  return {};
}

std::string copy_disk(const TempFolder& folder, const std::string& name) {
  const std::string disk = folder / name;
  run_tool("/bin/cp", {"--sparse=always", image_folder() + "/disk.img", disk});
  return disk;
}

PartitionPlace find_in_disk(const std::string& disk, const std::string& partition) {
  // GPT: entries of 128 bytes from the third sector on; first and last sector at 32, the name in UTF-16 at 56.
  std::ifstream file(disk, std::ios::binary);
  file.seekg(2 * kSector_bytes);
  for (int i = 0; i < 128; ++i) {
    char entry[128];
    if (!file.read(entry, sizeof entry)) break;
    std::string name;
    for (std::size_t c = 56; c < 128 && entry[c] != 0; c += 2) name += entry[c];
    if (name != partition) continue;
    std::uint64_t first = 0, last = 0;
    std::memcpy(&first, entry + 32, sizeof first);
    std::memcpy(&last, entry + 40, sizeof last);
    return {first * kSector_bytes, (last - first + 1) * kSector_bytes};
  }
  throw std::runtime_error(disk + " has no partition " + partition);
}

void put_on_data(const std::string& disk, const std::string& file, const std::string& name) {
  const std::string place = fmt::format("{}?offset={}", disk, find_in_disk(disk, "data").begin_bytes);
  Program remove("/sbin/debugfs", {"-w", "-R", "rm " + name, place});
  (void)remove.finish();
  run_tool("/sbin/debugfs", {"-w", "-R", "write " + file + " " + name, place});
}

void get_from_data(const std::string& disk, const std::string& name, const std::string& folder) {
  const PartitionPlace place = find_in_disk(disk, "data");
  const std::string part = folder + "/data.img";
  run_tool("/bin/dd", {"if=" + disk, "of=" + part, "bs=1M", fmt::format("skip={}", place.begin_bytes >> 20U),
                       fmt::format("count={}", place.size_bytes >> 20U), "status=none"});
  // 0: nothing to do, 1: the journal was replayed
  Program check("/sbin/e2fsck", {"-fy", part});
  if (const ProgramResult result = check.finish(); result.exit_code > 1)
    throw std::runtime_error("e2fsck: " + result.out);
  run_tool("/sbin/debugfs", {"-R", "rdump " + name + " " + folder, part});
}

RobotMachine::RobotMachine(const std::string& world, const std::vector<std::string>& network, int number)
    : disk_(copy_disk(folder_, "disk.img")) {
  const std::string base = folder_ / "base", camera = folder_ / "camera";
  building_ = std::make_unique<Program>(
      g3dmap_path(), std::vector<std::string>{"building", "--world", world, "--camera", "160x120@5", "--slow",
                                              fmt::format("{}", kSlow), "--at", folder_ / "building", "--base",
                                              "unix:" + base, "--frames", "listen:" + camera, "--quiet"});
  machine_ = std::make_unique<Machine>(MachineOptions{disk_, base, camera, network, number});
}

RobotMachine::~RobotMachine() = default;

std::string RobotMachine::truth() const { return run_g3dmap({"tell", folder_.path() + "/building", "status"}).out; }
double RobotMachine::truth_of(const std::string& key) const { return number_after(truth(), key); }
double RobotMachine::driven_m() const { return truth_of("driven_m"); }
double RobotMachine::turned_rad() const { return truth_of("turned_rad"); }
double RobotMachine::speed_mps() const { return truth_of("speed_mps"); }
double RobotMachine::told_mmps() const { return truth_of("told_mmps"); }

bool RobotMachine::moves_within(std::chrono::seconds limit) const {
  const double driven_m_before = driven_m(), turned_rad_before = turned_rad();
  const auto end = std::chrono::steady_clock::now() + limit;
  while (std::chrono::steady_clock::now() < end) {
    if (driven_m() > driven_m_before + 0.02 || turned_rad() > turned_rad_before + 0.05) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  return false;
}

bool RobotMachine::stands_within(std::chrono::seconds limit) const {
  const auto end = std::chrono::steady_clock::now() + limit;
  double driven_m_before = driven_m(), turned_rad_before = turned_rad();
  while (std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::seconds(2));
    const double driven_m_now = driven_m(), turned_rad_now = turned_rad();
    if (driven_m_now - driven_m_before < 1e-4 && turned_rad_now - turned_rad_before < 1e-4) return true;
    driven_m_before = driven_m_now;
    turned_rad_before = turned_rad_now;
  }
  return false;
}

}  // namespace g3d::test
