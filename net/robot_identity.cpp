// SPDX-License-Identifier: Apache-2.0
#include "net/robot_identity.hpp"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace g3d::net {
namespace {

constexpr std::size_t kMachineText_bytes = 128;
constexpr std::string_view kMachinePurpose = "g3dmap robot id";  // the hash's key: at least 16 bytes with its end

/// What stands in a file, without the space around it; empty if there is none, or nothing.
std::string first_line(const std::string& path) {
  std::ifstream file(path);
  std::string text(kMachineText_bytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  text.resize(std::min(text.find_first_of("\r\n \t"), text.size()));
  return text;
}

/// Of a cable or a radio; bridges and the like are made anew at each start.
std::string lowest_address(const std::string& folder) {
  std::string lowest;
  std::error_code code;
  for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    std::error_code ignored;
    if (!std::filesystem::exists(entry->path() / "device", ignored)) continue;
    const std::string address = first_line((entry->path() / "address").string());
    if (address.empty() || address == "00:00:00:00:00:00") continue;
    if (lowest.empty() || address < lowest) lowest = address;
  }
  return lowest;
}

}  // namespace

hal::Result<RobotId> machine_robot_id(const MachineFiles& files) {
  std::string machine = first_line(files.machine_id);
  if (machine == "uninitialized") machine.clear();  // what systemd leaves in an image before its first start
  if (machine.empty()) machine = lowest_address(files.interfaces);
  if (machine.empty()) {
    return hal::Error{hal::Reason::not_found,
                      fmt::format("{}: no machine id, and no network card has an address, so this robot has no name; "
                                  "give it one: network.robot in the board file, or --robot",
                                  files.machine_id)};
  }
  std::array<unsigned char, crypto_generichash_BYTES> hash{};
  std::array<unsigned char, crypto_generichash_KEYBYTES> key{};
  std::memcpy(key.data(), kMachinePurpose.data(), kMachinePurpose.size());
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(machine.data()), machine.size(),
                     key.data(), key.size());
  RobotId robot = 0;
  std::memcpy(&robot, hash.data(), sizeof robot);
  return robot != 0 ? robot : RobotId{1};
}

std::uint32_t fresh_incarnation() {
  std::uint32_t incarnation = 0;
  while (sodium_init() < 0 || incarnation == 0) incarnation = randombytes_random();
  return incarnation;
}

std::string text_of_robot(RobotId robot) { return fmt::format("{:016x}", robot); }

std::string text_of_layer(const LayerId& layer) {
  return fmt::format("{:016x}.{:08x}", layer.robot, layer.incarnation);
}

}  // namespace g3d::net
