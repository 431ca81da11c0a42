// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/builtin_worlds.hpp"

#include <array>

#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {
namespace {

struct Place {
  std::string_view name;
  std::string_view world;
  std::string_view path;
};

std::array<Place, 17> places() {
  return {{{"furnished_room", kFurnishedRoomWorld, kFurnishedRoomPath},
           {"two_rooms", kTwoRoomsWorld, kTwoRoomsPath},
           {"corridor", kCorridorWorld, kCorridorPath},
           {"office", kOfficeWorld, kOfficePath},
           {"visitor", kVisitorWorld, kVisitorPath},
           {"house", kHouseWorld, {}},
           {"doorways", kDoorwaysWorld, {}},
           {"loops", kLoopsWorld, {}},
           {"maze", kMazeWorld, {}},
           {"warehouse", kWarehouseWorld, {}},
           {"hall", kHallWorld, {}},
           {"lab", kLabWorld, {}},
           {"glass", kGlassWorld, {}},
           {"people", kPeopleWorld, {}},
           {"passage", kPassageWorld, {}},
           {"crossings", kCrossingsWorld, {}},
           {"crowd", kCrowdWorld, {}}}};
}

Place by_name(std::string_view name) {
  for (const Place& place : places()) {
    if (place.name == name) return place;
  }
  return {};
}

}  // namespace

const std::vector<std::string_view>& builtin_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const Place& place : places()) all.push_back(place.name);
    return all;
  }();
  return names;
}

const std::vector<std::string_view>& exploration_names() {
  static const std::vector<std::string_view> names = {"office",  "loops",     "house",    "warehouse", "maze",
                                                      "hall",    "lab",       "doorways", "glass",     "people",
                                                      "passage", "crossings", "crowd"};
  return names;
}

std::string_view builtin_world(std::string_view name) { return by_name(name).world; }
std::string_view builtin_path(std::string_view name) { return by_name(name).path; }

}  // namespace g3d::hal
