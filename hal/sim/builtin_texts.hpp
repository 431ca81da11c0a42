// SPDX-License-Identifier: Apache-2.0
// Texts of the built-in worlds, in the form of world files and camera paths. Reached by name: see builtin_worlds.hpp.
#pragma once

#include <string_view>

namespace g3d::hal {

extern const std::string_view kFurnishedRoomWorld;
extern const std::string_view kFurnishedRoomPath;
extern const std::string_view kTwoRoomsWorld;
extern const std::string_view kTwoRoomsPath;
extern const std::string_view kCorridorWorld;
extern const std::string_view kCorridorPath;
extern const std::string_view kOfficeWorld;
extern const std::string_view kOfficePath;
extern const std::string_view kVisitorWorld;
extern const std::string_view kVisitorPath;

extern const std::string_view kHouseWorld;
extern const std::string_view kDoorwaysWorld;
extern const std::string_view kLoopsWorld;
extern const std::string_view kMazeWorld;
extern const std::string_view kWarehouseWorld;
extern const std::string_view kHallWorld;
extern const std::string_view kPeopleWorld;
extern const std::string_view kLabWorld;
extern const std::string_view kGlassWorld;
extern const std::string_view kPassageWorld;
extern const std::string_view kCrossingsWorld;
extern const std::string_view kCrowdWorld;

}  // namespace g3d::hal
