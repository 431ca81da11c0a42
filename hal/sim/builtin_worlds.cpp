// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/builtin_worlds.hpp"

#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {
namespace {

std::string_view by_name(std::string_view name, bool world) {
  if (name == "furnished_room") return world ? kFurnishedRoomWorld : kFurnishedRoomPath;
  if (name == "two_rooms") return world ? kTwoRoomsWorld : kTwoRoomsPath;
  if (name == "corridor") return world ? kCorridorWorld : kCorridorPath;
  if (name == "office") return world ? kOfficeWorld : kOfficePath;
  if (name == "visitor") return world ? kVisitorWorld : kVisitorPath;
  return {};
}

}  // namespace

const std::vector<std::string_view>& builtin_names() {
  static const std::vector<std::string_view> names = {"furnished_room", "two_rooms", "corridor", "office", "visitor"};
  return names;
}

std::string_view builtin_world(std::string_view name) { return by_name(name, true); }
std::string_view builtin_path(std::string_view name) { return by_name(name, false); }

}  // namespace g3d::hal
