// SPDX-License-Identifier: Apache-2.0
// Places full of people: a passage where they come towards the robot, corners from behind which they come, a crowd.
#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {

const std::string_view kPassageWorld =
    R"(# A passage of 10 x 1.8 m between two rooms, with two chambers beside it. People come along it towards whoever is in it.
room 0 0 0  18 6 2.6  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#8f8a86 floor2=#827d79 ceiling=#f0eee6
box -3.35 0.95 0  3.3 0.1 2.6  color=#c7d3b8
box 1.65 0.95 0  4.7 0.1 2.6  color=#c7d3b8
box -4.95 1.95 0  0.1 2.1 2.6  color=#c7d3b8
box 4.95 1.95 0  0.1 2.1 2.6  color=#c7d3b8
box 0 1.95 0  0.1 2 2.6  color=#c7d3b8
box -1.65 -0.95 0  6.7 0.1 2.6  color=#d9c7a0
box 3.85 -0.95 0  2.3 0.1 2.6  color=#d9c7a0
box -4.95 -1.95 0  0.1 2.1 2.6  color=#d9c7a0
box 4.95 -1.95 0  0.1 2.1 2.6  color=#d9c7a0
box -1.8 -2 0  6.2 2 1.2  color=#b9cbb4
box 7 2.6 0  1.6 0.6 0.8  color=#8a5a33
box -8.6 0 0  0.6 1.4 0.9  color=#6b4a3a
shelves 8.7 -1.5 0  1.4 0.36 1.8 5 90  color=#c9b28f
cylinder -6.2 2.5 0  0.25 1.1  color=#a5522d
person 1.75 0.22  0,-6.6,0.1 12,6.4,0.1 14,6.4,1.2 15,6.4,0.1 28,-6.6,0.1  color=#3c5a80 color2=#2f4866 texture=stripes:0.25
person 1.62 0.2  0,6.3,-0.4 18,-6.3,-0.4 20,-6.3,-2 22,-6.3,-0.4 40,6.3,-0.4  color=#80503c
person 1.8 0.23  0,-7.2,-2 9,-7.2,2 12,-5.8,-0.2 19,3.5,0 22,-0.8,0 26,-5.8,-0.2 30,-7.2,-2  color=#4f7a45
start -7.2 1.4 0
start 7 0.4 180
start 0.9 0.1 0
)";

const std::string_view kCrossingsWorld =
    R"(# Four blocks of houses with streets of 1.6 m between and around them: people come from behind every corner.
room 0 0 0  12.4 10 2.6  0.1  color=#cdd3d8 color2=#bfc6cc texture=stripes:0.5 floor=#a89a86 floor2=#9a8c78 ceiling=#f0eee6
box -2.7 2.1 0  3.8 2.6 2.6  color=#c7d3b8 color2=#b8c6a8 texture=stripes:0.3
box 2.7 2.1 0  3.8 2.6 2.6  color=#d9c7a0 color2=#cbb88e texture=stripes:0.3
box -2.7 -2.1 0  3.8 2.6 2.6  color=#9fb7c9
box 2.7 -2.1 0  3.8 2.6 2.6  color=#cfa9a0 color2=#c2988e texture=checker:0.2
person 1.75 0.22  0,-5.4,-4.2 9,-5.4,4.2 20,5.4,4.2 29,5.4,-4.2 40,-5.4,-4.2  color=#3c5a80 color2=#2f4866 texture=stripes:0.25
person 1.65 0.2  0,0,4.2 7,0,-4.2 13,5.4,-4.2 20,5.4,0 26,0,0 30,0,4.2  color=#80503c
person 1.85 0.24  0,5.4,0.2 10,-5.4,0.2 14,-5.4,-4.2 20,0.1,-4.2 24,0.1,0.2 30,5.4,0.2  color=#4f7a45
person 1.7 0.21  0,-0.2,-4.2 9,-0.2,4.2 16,-5.4,4.2 21,-5.4,0 28,-0.2,0 33,-0.2,-4.2  color=#705080
start -5.3 1.5 -90
start 5.3 4.2 180
start 0.3 -1.8 90
)";

const std::string_view kCrowdWorld =
    R"(# A hall of 13 x 10 m with two pillars, benches and a counter, in which nine people walk to and fro.
room 0 0 0  13 10 3.2  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#a08c70 floor2=#928064 ceiling=#f0eee6
cylinder -2.6 0.4 0  0.3 3.2  color=#d8d2c4
cylinder 2.8 -0.6 0  0.3 3.2  color=#d8d2c4
box 0 4.6 0.1  2.2 0.45 0.35  color=#8a5a33
box -4 -4.6 0  1.8 0.45 0.45  color=#8a5a33
box 6 1 0  0.7 2.6 1.1  color=#6b4a3a
box -6.2 -1 0  0.4 1.6 1.8  color=#c9b28f
person 1.75 0.22  0,-5.4,-3.4 10,-5.4,3.6 18,-1,3.6 27,-1,-3.4 34,-5.4,-3.4  color=#3c5a80 color2=#2f4866 texture=stripes:0.25
person 1.65 0.2  0,-4.6,2.8 9,4.4,2.6 15,4.6,-2.6 23,-4.4,-2.8 30,-4.6,2.8  color=#80503c
person 1.85 0.24  0,0.4,3.9 8,0.4,-3.9 14,4.4,-3.9 24,4.6,3.6 30,0.4,3.9  color=#4f7a45
person 1.7 0.21  0,-3.6,-0.8 6,1.4,-0.8 12,1.4,1.6 18,-3.6,1.6 22,-3.6,-0.8  color=#705080
person 1.6 0.19  0,5.2,-4.2 7,5.2,-0.6 11,1.6,0.4 16,1.2,-4.2 21,5.2,-4.2  color=#a04040
person 1.8 0.23  0,-1.6,-4.2 12,-1.6,4 24,-1.6,-4.2  color=#406060
person 1.72 0.22  0,3.6,4.2 14,-4.8,-3.6 28,3.6,4.2  color=#606020
person 1.55 0.18  0,-5.6,0.6 5,-3.2,-1.6 9,-1.2,-0.4 14,-3.4,3.2 19,-5.6,0.6  color=#c08040
person 1.78 0.22  0,5,3.4 6,1.9,1.2 14,1.9,-3.2 22,5.4,-2 28,5,3.4  color=#305030
start -5.6 -4.2 45
start 5.4 4 200
start 0.6 0.2 -90
)";

}  // namespace g3d::hal
