// SPDX-License-Identifier: Apache-2.0
// Smaller places: two closed rooms, an office, a room with a visitor.
#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {

const std::string_view kTwoRoomsWorld =
    R"(# Two closed rooms of 4 x 4 x 2.4 m, a closed wall of 10 cm between them (x -0.05 to 0.05) and 10 cm around both.
floor 0 0 0  8.3 4.2 0.1  color=#b59a78 color2=#a58a68 texture=checker:0.4
box 0 0 2.4  8.3 4.2 0.1  color=#f0eee6
box -4.1 0 0  0.1 4.2 2.4  color=#9fb7c9
box  4.1 0 0  0.1 4.2 2.4  color=#9fb7c9
box 0  2.05 0  8.1 0.1 2.4  color=#d9c7a0 color2=#cbb88e texture=stripes:0.3
box 0 -2.05 0  8.1 0.1 2.4  color=#c7d3b8 color2=#b8c6a8 texture=stripes:0.3
box 0 0 0  0.1 4 2.4  color=#cfa9a0 color2=#c2988e texture=checker:0.2
# Western room
box -3.7 -1.6 0  0.5 0.6 0.9  color=#8a5a33
shelves -1.4 1.82 0  1.0 0.3 1.6 5  color=#d8c49a
box -1.5 1.85 0.02  0.6 0.2 0.3  color=#2d4f8f color2=#e0c040 texture=stripes:0.06
pole -0.4 -1.5 0  0.0125 2.4  color=#c02040
pole -2.2 1.4 0  0.01 2.4  color=#f0c000
sphere -0.45 0.4 0.2  0.2  color=#e05020
cone -3.6 1.6 0  0.2 0.5 0.3  color=#a5522d
sphere -3.6 1.6 0.8  0.35  color=#3e8a3a
box -0.3 1.2 0.6  0.06 0.5 0.5  color=#15171a dark
box -0.3 1.2 0  0.3 0.6 0.6  color=#5f5048
# Eastern room: must never be seen from the western one
box 2 0 0  1.2 0.8 0.75  color=#3f7f6b
cylinder 3.5 1.5 0  0.3 1.2  color=#8060a0
sphere 1 -1.2 0.3  0.3  color=#3060c0
start -2 -0.1 0
)";

const std::string_view kTwoRoomsPath = R"(0.0 -1.300 -0.100 0.60 -90.0 0.0
1.0 -1.337 0.132 0.60 -54.0 9.7
2.0 -1.443 0.341 0.60 -18.0 11.4
3.0 -1.609 0.507 0.60 18.0 3.7
4.0 -1.818 0.613 0.60 54.0 -7.1
5.0 -2.050 0.650 0.60 90.0 -12.0
6.0 -2.282 0.613 0.60 126.0 -7.1
7.0 -2.491 0.507 0.60 162.0 3.7
8.0 -2.657 0.341 0.60 -162.0 11.4
9.0 -2.763 0.132 0.60 -126.0 9.7
10.0 -2.800 -0.100 0.60 -90.0 0.0
11.0 -2.763 -0.332 0.60 -54.0 -9.7
12.0 -2.657 -0.541 0.60 -18.0 -11.4
13.0 -2.491 -0.707 0.60 18.0 -3.7
14.0 -2.282 -0.813 0.60 54.0 7.1
15.0 -2.050 -0.850 0.60 90.0 12.0
16.0 -1.818 -0.813 0.60 126.0 7.1
17.0 -1.609 -0.707 0.60 162.0 -3.7
18.0 -1.443 -0.541 0.60 -162.0 -11.4
19.0 -1.337 -0.332 0.60 -126.0 -9.7
20.0 -1.300 -0.100 0.60 -90.0 -0.0
)";

const std::string_view kOfficeWorld =
    R"(# 12 x 8 x 2.7 m: an open part with eight desks, a meeting room behind a partition with a glass door, a kitchenette.
floor 0 0 0  12.3 8.3 0.15  color=#7f8790 color2=#757d86 texture=checker:0.5
box 0 0 2.7  12.3 8.3 0.15  color=#f2f2ee
box -6.075 0 0  0.15 8.3 2.7  color=#d7dcd8
box  6.075 0 0  0.15 8.3 2.7  color=#8fb0b8 color2=#84a5ad texture=stripes:0.5
box 0  4.075 0  12 0.15 2.7  color=#e0dccf color2=#d3cfc0 texture=stripes:1.0
box 0 -4.075 0  12 0.15 2.7  color=#e6d3b8
# Windows in the northern wall
box -3.5 3.98 1.0  2.4 0.04 1.3  color=#a6cdec
box -3.5 3.97 0.95  2.5 0.08 0.05  color=#fafaf5
box  0.0 3.98 1.0  2.4 0.04 1.3  color=#a6cdec
box  0.0 3.97 0.95  2.5 0.08 0.05  color=#fafaf5
# Meeting room in the east: partition x = 2.5 with a door gap, glass pane in it
box 2.5 2.6 0  0.1 2.8 2.7  color=#c9c2d4
box 2.5 -2.6 0  0.1 2.8 2.7  color=#c9c2d4
box 2.5 0 2.1  0.1 2.4 0.6  color=#c9c2d4
box 2.5 0.75 0  0.03 0.9 2.1  color=#a8d8d8 glass
box 4.3 0 0.71  1.2 2.4 0.04  color=#6b4a3a color2=#604030 texture=stripes:0.12
cylinder 4.3 0 0  0.12 0.71  color=#505058
cylinder 4.3 0 0  0.45 0.012  color=#505058
box 3.3 0.7 0.42  0.45 0.45 0.06 5  color=#c8553d
box 3.1 0.7 0.48  0.05 0.45 0.5 5  color=#c8553d
pole 3.3 0.7 0  0.025 0.42  color=#808088
box 3.35 -0.9 0.42  0.45 0.45 0.06 -8  color=#3f7f6b
box 3.15 -0.88 0.48  0.05 0.45 0.5 -8  color=#3f7f6b
pole 3.35 -0.9 0  0.025 0.42  color=#808088
box 5.97 0 1.0  0.04 1.6 0.9  color=#14161a dark
box 4.3 3.9 0.9  2.4 0.03 1.2  color=#fbfbfb
# Two islands of four desks, screens between
box -3.6  0.4 0.7  1.6 0.75 0.04  color=#e3d9c4
box -3.6 -0.4 0.7  1.6 0.75 0.04  color=#e3d9c4
box -2.0  0.4 0.7  1.55 0.75 0.04  color=#e3d9c4
box -2.0 -0.4 0.7  1.55 0.75 0.04  color=#e3d9c4
box -2.8 0 0  3.2 0.04 1.2  color=#5b7f95 color2=#52758a texture=stripes:0.4
box -4.36 0.4 0  0.04 0.7 0.7  color=#b0a898
box -4.36 -0.4 0  0.04 0.7 0.7  color=#b0a898
box -1.25 0.4 0  0.04 0.7 0.7  color=#b0a898
box -1.25 -0.4 0  0.04 0.7 0.7  color=#b0a898
box -3.6 0.18 0.84  0.55 0.04 0.34  color=#15171a dark
box -2.0 0.18 0.84  0.55 0.04 0.34  color=#15171a dark
box -3.6 -0.18 0.84  0.55 0.04 0.34  color=#30343a
box -2.0 -0.18 0.84  0.55 0.04 0.34  color=#30343a
box -3.5 1.1 0.45  0.48 0.48 0.06 15  color=#2f4858
box -3.55 1.33 0.51  0.45 0.05 0.5 15  color=#2f4858
pole -3.5 1.1 0.06  0.03 0.4  color=#8a8a90
cylinder -3.5 1.1 0  0.25 0.1  color=#55565a
box -2.1 -1.1 0.45  0.48 0.48 0.06 -20  color=#86340f
box -2.18 -1.33 0.51  0.45 0.05 0.5 -20  color=#86340f
pole -2.1 -1.1 0.06  0.03 0.4  color=#8a8a90
cylinder -2.1 -1.1 0  0.25 0.1  color=#55565a
# Kitchenette and shelves in the south, copier in the west
box -4.6 -3.7 0  2.4 0.6 0.9  color=#f4f1e8 color2=#e2ded0 texture=stripes:0.6
box -4.6 -3.85 1.5  2.4 0.3 0.6  color=#f4f1e8 color2=#e2ded0 texture=stripes:0.6
cylinder -5.2 -3.7 0.9  0.08 0.25  color=#c03030
box -3.8 -3.75 0.9  0.3 0.3 0.35  color=#303030
shelves -1.0 -3.82 0  1.4 0.34 2.0 6  color=#c0b090
box -1.2 -3.85 0.02  0.8 0.24 0.3  color=#7a3e7a color2=#d59bd5 texture=stripes:0.07
box -0.8 -3.85 0.416  0.7 0.24 0.28  color=#2e6e4e color2=#a8c686 texture=stripes:0.07
box -1.1 -3.85 0.812  1.0 0.24 0.28  color=#20639b color2=#f6d55c texture=stripes:0.08
box -5.7 1.5 0  0.5 0.6 1.0  color=#d0d4d8
box -5.7 1.5 1.0  0.45 0.5 0.15  color=#50565c
# Plants, coat stand, bin, cartons, stairs up to a platform
cone 1.9 3.5 0  0.18 0.4 0.25  color=#e8e4da
sphere 1.9 3.5 0.85  0.36  color=#3e8a3a
cone 1.0 -3.6 0  0.15 0.32 0.2  color=#3c78a8
cone 1.0 -3.6 0.32  0.3 0.9 0  color=#2f7d3b
pole 2.1 -3.5 0  0.015 1.8  color=#38322c
sphere 2.1 -3.5 1.85  0.1  color=#7c4f2f
cylinder -0.8 1.0 0  0.14 0.35  color=#b0b4b8
box -5.5 3.4 0  0.6 0.5 0.4 20  color=#c79a63
stairs 0.3 2.9 0  0.9 0.28 0.17 3  color=#c2b59b color2=#a6987c texture=stripes:0.2
pole 1.2 1.6 0  0.0125 2.7  color=#c02040
start -0.3 0.2 180
start 1.6 -2.4 90
start -5.1 0 -90
)";

const std::string_view kOfficePath = R"(0 -0.3 0.0 0.6 180 -5
3 -0.3 1.2 0.6 200 0
6 -1.2 2.1 0.6 240 -8
9 -2.6 2.2 0.6 270 5
12 -4.0 2.2 0.6 180 10
15 -5.1 2.2 0.6 90 -5
18 -5.1 0.8 0.6 20 -5
21 -5.1 -0.9 0.6 -20 0
24 -4.9 -2.2 0.6 -90 5
27 -3.5 -2.4 0.6 -40 0
30 -2.0 -2.4 0.6 60 -5
33 -0.5 -2.4 0.6 -30 5
36 0.9 -2.0 0.6 30 0
39 1.5 -0.6 0.6 0 -5
42 2.5 -0.35 0.6 20 0
45 3.3 -0.1 0.6 -40 10
46.5 3.2 -0.1 0.6 0 0
48 3.3 -0.1 0.6 60 5
51 2.5 -0.35 0.6 150 0
54 1.4 0.2 0.6 110 -5
57 0.4 1.0 0.6 140 0
60 -0.3 0.0 0.6 180 -5
)";

const std::string_view kVisitorWorld =
    R"(# A room of 6 x 5 x 2.5 m. Somebody enters from the right at 2 s, comes to within half a metre of the camera's place,
# stands there, and leaves to the left; after 13 s the view is empty again.
room 0 0 0  6 5 2.5  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#9a8668 floor2=#8c795c ceiling=#f0eee6
box 2.7 1.5 0  0.5 1.2 0.9  color=#8a5a33
shelves 2.8 -1.4 0  1.0 0.3 1.6 5 90  color=#d8c49a
pole 1.6 1.6 0  0.0125 2.5  color=#c02040
person 1.75 0.22  2,1.2,-4.5 5,0.6,0 8,-1.1,0 9,-1.1,0 11,0.6,0.4 13,1.2,4.5  color=#3c5a80 color2=#2f4866 texture=stripes:0.25
start -2 0 0
)";

const std::string_view kVisitorPath = R"(0 -2 0 0.8 0 0
16 -2 0 0.8 0 0
)";

}  // namespace g3d::hal
