// SPDX-License-Identifier: Apache-2.0
// An emulated machine with the image of this checkout, and the simulated building that its base and camera are in.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "tests/emulated/machine.hpp"

namespace g3d::test {

/// How many times slower than real time robot and building live here: an emulated core has a tenth of a real one's
/// speed, and the machine that emulates it may be busy.
inline constexpr int kSlow = 4;

/// Whoever emulates it may be busy; without that a boot takes 20 s, and a robot moves within some.
inline constexpr std::chrono::seconds kBootLimit{300}, kMoveLimit{120};
/// What the console shows as soon as the first frame is in the map.
inline constexpr const char* kMapping = "the robot maps";

/// Why there can be no emulated robot here, for people; empty: nothing is missing.
[[nodiscard]] std::string no_robot_machine();

/// The image's disk, copied; G3DMAP_IMAGE names the folder that scripts/image made.
[[nodiscard]] std::string copy_disk(const TempFolder& folder, const std::string& name);
/// Where a partition begins in a disk image, and how long it is; throws if there is none of that name.
struct PartitionPlace {
  std::uint64_t begin_bytes = 0, size_bytes = 0;
};
[[nodiscard]] PartitionPlace find_in_disk(const std::string& disk, const std::string& partition);
/// Writes a file into the data partition of a machine that is off. `name`: without a folder.
void put_on_data(const std::string& disk, const std::string& file, const std::string& name);
/// Copies a folder of the data partition of a machine that is off, as its journal makes it after a power cut.
void get_from_data(const std::string& disk, const std::string& name, const std::string& folder);

class RobotMachine {
 public:
  /// `network`: QEMU's arguments of a netdev "net"; empty: no network card.
  explicit RobotMachine(const std::string& world, const std::vector<std::string>& network = {}, int number = 1);
  ~RobotMachine();
  RobotMachine(const RobotMachine&) = delete;
  RobotMachine& operator=(const RobotMachine&) = delete;

  [[nodiscard]] Machine& machine() { return *machine_; }
  [[nodiscard]] const std::string& disk() const { return disk_; }
  /// What the building knows of the robot, in its own JSON.
  [[nodiscard]] std::string truth() const;
  [[nodiscard]] double driven_m() const;
  [[nodiscard]] double turned_rad() const;
  [[nodiscard]] double speed_mps() const;
  /// By the last command that came to the base.
  [[nodiscard]] double told_mmps() const;
  /// Until it has driven or turned by more than it had.
  [[nodiscard]] bool moves_within(std::chrono::seconds limit) const;
  /// Until it has stood for a second.
  [[nodiscard]] bool stands_within(std::chrono::seconds limit) const;

 private:
  [[nodiscard]] double truth_of(const std::string& key) const;

  TempFolder folder_;
  std::string disk_;
  std::unique_ptr<Program> building_;
  std::unique_ptr<Machine> machine_;
};

}  // namespace g3d::test
