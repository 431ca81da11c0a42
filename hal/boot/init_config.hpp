// SPDX-License-Identifier: Apache-2.0
// What the first process of an image is told: init.toml on the data partition, else in the system slot, else nothing
// but the defaults. What a file leaves out keeps its default; unknown keys, wrong types and values out of range are
// errors that name file and line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"

namespace g3d::hal::boot {

/// An own address that never changes, for one network card.
struct FixedAddress {
  std::uint32_t ipv4 = 0;  ///< host byte order
  int prefix_bits = 24;    ///< 1 to 30
  bool operator==(const FixedAddress&) const = default;
};

enum class WhenDone : std::uint8_t { stay, again, power_off };

struct InitConfig {
  std::string name = "g3dmap";  ///< of the machine; answers to NAME.local. Letters, digits, '-', at most 32
  /// Of the program in the system slot.
  std::vector<std::string> arguments = {
      "run",        "--board", "/system/board.toml", "--out",        "/data/out", "--keep",
      "/data/keep", "--key",   "/data/fleet.key",    "--await-base", "--quiet"};
  WhenDone when_done = WhenDone::stay;   ///< when the robot has ended well: home, everything saved
  std::string interface = "auto";        ///< network card; "auto": the first that is no loopback; "none"
  std::optional<FixedAddress> address;   ///< none: IPv4 link-local
  std::optional<std::uint32_t> gateway;  ///< host byte order
  int watchdog_s = 10;                   ///< hardware watchdog's patience, 2 to 60
  int silent_ms = 5000;      ///< how long a running robot may be silent before the watchdog is not fed, 200 to 30000
  int start_s = 120;         ///< how long it may take until it says that it runs, 5 to 600
  int prove_s = 30;          ///< so long it has to run until a new system is taken for good, 1 to 3600
  bool can_virtual = false;  ///< make vcan0 where there is no bus: for the emulated machine
  bool operator==(const InitConfig&) const = default;
};

/// `file` is what errors call the text.
[[nodiscard]] Result<InitConfig> parse_init_config(std::string_view text, std::string_view file);
[[nodiscard]] Result<InitConfig> load_init_config(const std::string& path);

/// "10.0.0.2" of an address in host byte order.
[[nodiscard]] std::string ipv4_text(std::uint32_t ipv4);

}  // namespace g3d::hal::boot
