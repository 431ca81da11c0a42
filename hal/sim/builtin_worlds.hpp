// SPDX-License-Identifier: Apache-2.0
// Worlds and drives that are compiled into the program, in the same text form that files have. With a drive for a
// camera:
//   furnished_room  10 x 10 x 2.5 m, about 150 solids, a minute's drive that sees nearly all of it
//   two_rooms       two closed rooms with a 10 cm wall between them; the drive stays in the western one
//   corridor        a loop of 60 m through closed corridors
//   office          desks, partitions, shelves, a glass door
//   visitor         a plain room that a person walks through while the camera stands still
// To explore, closed all round, with starts for robots (and so are `office` and `corridor`):
//   house           five rooms with furniture          doorways   nine rooms, doorways of 0.55 to 0.60 m
//   loops           corridors around three cores       maze       7 x 7 cells of 1.25 m
//   warehouse       racks and aisles                   hall       wider than the camera can measure
//   lab             cluttered                          glass      panes, black furniture
//   people          three of them walk their rounds    passage    people come towards the robot where it is narrow
//   crossings       people come from behind corners    crowd      nine of them in a hall
#pragma once

#include <string_view>
#include <vector>

namespace g3d::hal {

[[nodiscard]] const std::vector<std::string_view>& builtin_names();
/// The worlds that robots explore in benchmarks.
[[nodiscard]] const std::vector<std::string_view>& exploration_names();
/// The text, or empty if there is no such name.
[[nodiscard]] std::string_view builtin_world(std::string_view name);
/// Empty also where a world has no drive.
[[nodiscard]] std::string_view builtin_path(std::string_view name);

}  // namespace g3d::hal
