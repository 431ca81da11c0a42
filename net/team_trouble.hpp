// SPDX-License-Identifier: Apache-2.0
// What a simulated team has to live with, as it is said on the command line: radio that is cut between groups of robots
// for a while, and robots that die.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::net {

inline constexpr std::uint32_t kMostTeam = 16;

struct RadioCut {
  hal::TimeNs from_ns = 0;
  hal::TimeNs to_ns = 0;                        ///< the first moment after it
  std::array<std::uint8_t, kMostTeam> group{};  ///< by robot, from 0; group 0: of those that were not named
};
/// Whether two robots, counted from 0, hear each other as far as that goes.
[[nodiscard]] bool is_cut(std::span<const RadioCut> cuts, std::uint32_t a, std::uint32_t b, hal::TimeNs now_ns);

struct RobotDeath {
  std::uint32_t robot = 0;  ///< from 0
  hal::TimeNs at_ns = 0;
};

/// "FROM-TO:1,2|3,4" in seconds: robots, counted from 1, hear their own group alone; who is in none hears others who
/// are in none. Errors: bad_usage, with what would be right.
[[nodiscard]] hal::Result<RadioCut> parse_cut(std::string_view text, std::uint32_t robots);
/// "ROBOT@SECONDS", counted from 1.
[[nodiscard]] hal::Result<RobotDeath> parse_death(std::string_view text, std::uint32_t robots);

struct TeamTrouble {
  std::vector<RadioCut> cuts;
  std::vector<RobotDeath> deaths;
};
/// All of `--partition` and `--kill`; errors begin with these.
[[nodiscard]] hal::Result<TeamTrouble> parse_trouble(std::span<const std::string> cuts,
                                                     std::span<const std::string> deaths, std::uint32_t robots);

}  // namespace g3d::net
