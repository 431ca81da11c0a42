// SPDX-License-Identifier: Apache-2.0
// Places of many rooms: a house, rooms with narrow doorways, corridors in loops, a maze.
#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {

const std::string_view kHouseWorld =
    R"(# A house of 10 x 8 m: living room and kitchen in the south, two bedrooms and a bath in the north.
room 0 0 0  10 8 2.5  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#9a8668 floor2=#8c795c ceiling=#f0eee6
box -4.325 0.6 0  1.35 0.1 2.5  color=#d9c7a0
box -3.2 0.6 2.05  0.9 0.1 0.45  color=#d9c7a0
box -1.45 0.6 0  2.6 0.1 2.5  color=#d9c7a0
box 0.3 0.6 2.05  0.9 0.1 0.45  color=#d9c7a0
box 1.875 0.6 0  2.25 0.1 2.5  color=#d9c7a0
box 3.4 0.6 2.05  0.8 0.1 0.45  color=#d9c7a0
box 4.4 0.6 0  1.2 0.1 2.5  color=#d9c7a0
box -1.5 2.325 0  0.1 3.35 2.5  color=#c7d3b8
box 2.2 2.325 0  0.1 3.35 2.5  color=#e3c3a0
box 1.6 -2.85 0  0.1 2.3 2.5  color=#b9cbb4
box 1.6 -1.2 2.05  0.1 1 0.45  color=#b9cbb4
box 1.6 -0.075 0  0.1 1.25 2.5  color=#b9cbb4
# Living room
box -4.5 -2.2 0.08  0.9 2 0.36  color=#4d6d8f
box -4.85 -2.2 0.44  0.2 2 0.42  color=#456483
box -3.1 -2.2 0.38  0.7 1.2 0.04  color=#8a5a33
box -3.4 -2.75 0  0.06 0.06 0.38  color=#6b4423
box -3.4 -1.65 0  0.06 0.06 0.38  color=#6b4423
box -2.8 -2.75 0  0.06 0.06 0.38  color=#6b4423
box -2.8 -1.65 0  0.06 0.06 0.38  color=#6b4423
box -1.2 -3.75 0  1.8 0.45 0.5  color=#6b4a3a
box -1.2 -3.8 0.55  1.2 0.06 0.7  color=#404448
shelves 1.38 -3.1 0  1.2 0.34 1.9 6 90  color=#c9b28f
cylinder -4.6 0.15 0  0.2 0.45  color=#a5522d
sphere -4.6 0.15 0.8 0.3  color=#3e8a3a
box -0.6 -1.2 0.7  1.5 0.9 0.04  color=#8a5a33
box -1.3 -1.6 0  0.06 0.06 0.7  color=#6b4423
box -1.3 -0.8 0  0.06 0.06 0.7  color=#6b4423
box 0.1 -1.6 0  0.06 0.06 0.7  color=#6b4423
box 0.1 -0.8 0  0.06 0.06 0.7  color=#6b4423
box -0.9 -0.55 0.43  0.42 0.42 0.04  color=#d3b0a0
box -0.9 -0.36 0.47  0.42 0.04 0.45  color=#d3b0a0
box -1.08 -0.73 0  0.04 0.04 0.43  color=#5a4632
box -1.08 -0.37 0  0.04 0.04 0.43  color=#5a4632
box -0.72 -0.73 0  0.04 0.04 0.43  color=#5a4632
box -0.72 -0.37 0  0.04 0.04 0.43  color=#5a4632
box -0.2 -0.5 0.43  0.42 0.42 0.04  color=#c4c09a
box -0.2 -0.31 0.47  0.42 0.04 0.45  color=#c4c09a
box -0.38 -0.68 0  0.04 0.04 0.43  color=#5a4632
box -0.38 -0.32 0  0.04 0.04 0.43  color=#5a4632
box -0.02 -0.68 0  0.04 0.04 0.43  color=#5a4632
box -0.02 -0.32 0  0.04 0.04 0.43  color=#5a4632
box -0.9 -1.9 0.43  0.42 0.42 0.04  color=#a9bdd2
box -0.9 -2.09 0.47  0.42 0.04 0.45  color=#a9bdd2
box -1.08 -2.08 0  0.04 0.04 0.43  color=#5a4632
box -1.08 -1.72 0  0.04 0.04 0.43  color=#5a4632
box -0.72 -2.08 0  0.04 0.04 0.43  color=#5a4632
box -0.72 -1.72 0  0.04 0.04 0.43  color=#5a4632
box -0.25 -1.95 0.43  0.42 0.42 0.04  color=#d9c7a0
box -0.25 -2.14 0.47  0.42 0.04 0.45  color=#d9c7a0
box -0.43 -2.13 0  0.04 0.04 0.43  color=#5a4632
box -0.43 -1.77 0  0.04 0.04 0.43  color=#5a4632
box -0.07 -2.13 0  0.04 0.04 0.43  color=#5a4632
box -0.07 -1.77 0  0.04 0.04 0.43  color=#5a4632
box -3 -2.2 0  2.2 1.6 0.012  color=#39575a color2=#cfd8d0 texture=checker:0.2
# Kitchen
box 4.7 -2.2 0  0.6 3.2 0.9  color=#f4f1e8 color2=#e2ded0 texture=stripes:0.6
box 3.2 -3.7 0  2.4 0.6 0.9  color=#f0ece0
box 2 -3.65 0  0.65 0.65 1.8  color=#dfe4e8
box 2.9 -1 0.7  0.9 0.7 0.04  color=#8a5a33
box 2.5 -1.3 0  0.06 0.06 0.7  color=#6b4423
box 2.5 -0.7 0  0.06 0.06 0.7  color=#6b4423
box 3.3 -1.3 0  0.06 0.06 0.7  color=#6b4423
box 3.3 -0.7 0  0.06 0.06 0.7  color=#6b4423
box 2.9 -1.55 0.43  0.42 0.42 0.04  color=#c7d3b8
box 2.9 -1.74 0.47  0.42 0.04 0.45  color=#c7d3b8
box 2.72 -1.73 0  0.04 0.04 0.43  color=#5a4632
box 2.72 -1.37 0  0.04 0.04 0.43  color=#5a4632
box 3.08 -1.73 0  0.04 0.04 0.43  color=#5a4632
box 3.08 -1.37 0  0.04 0.04 0.43  color=#5a4632
box 3.6 -0.95 0.43  0.42 0.42 0.04  color=#e3c3a0
box 3.79 -0.95 0.47  0.04 0.42 0.45  color=#e3c3a0
box 3.42 -1.13 0  0.04 0.04 0.43  color=#5a4632
box 3.42 -0.77 0  0.04 0.04 0.43  color=#5a4632
box 3.78 -1.13 0  0.04 0.04 0.43  color=#5a4632
box 3.78 -0.77 0  0.04 0.04 0.43  color=#5a4632
cylinder 4.7 0.25 0  0.17 0.6  color=#b9cbb4
# Bedroom west
box -4 3.1 0.12  2 1.6 0.3  color=#8a6a4a
box -4 3.1 0.42  1.95 1.55 0.14  color=#f3f0ea
box -2.2 3.7 0  1.2 0.55 2  color=#a86f3d
box -4.75 1.95 0  0.4 0.4 0.5  color=#9c7448
box -2 1.4 0.7  0.8 0.5 0.04  color=#8a5a33
box -2.35 1.2 0  0.06 0.06 0.7  color=#6b4423
box -2.35 1.6 0  0.06 0.06 0.7  color=#6b4423
box -1.65 1.2 0  0.06 0.06 0.7  color=#6b4423
box -1.65 1.6 0  0.06 0.06 0.7  color=#6b4423
# Bath
box -1 3.1 0  0.8 1.7 0.55  color=#fafafa
box 1 3.75 0  0.6 0.45 0.85  color=#f5f5f5
box 1.95 1.7 0  0.4 0.55 0.42  color=#ffffff
cylinder 1.9 3.6 0  0.18 0.9  color=#d0d0d8
# Bedroom east
box 4 3.2 0.1  2 1.4 0.3  color=#7a5a3a
box 4 3.2 0.4  1.9 1.3 0.15  color=#e8eef4
box 2.55 3.5 0  0.5 0.9 1.1  color=#b98a55
box 4.6 1.5 0.43  0.42 0.42 0.04  color=#c9b28f
box 4.79 1.5 0.47  0.04 0.42 0.45  color=#c9b28f
box 4.42 1.32 0  0.04 0.04 0.43  color=#5a4632
box 4.42 1.68 0  0.04 0.04 0.43  color=#5a4632
box 4.78 1.32 0  0.04 0.04 0.43  color=#5a4632
box 4.78 1.68 0  0.04 0.04 0.43  color=#5a4632
sphere 2.7 1.6 0.18 0.18  color=#e05020
start -1.8 -3 90
start 3 -2.4 180
start -3.2 1.4 0
start 3.4 1.6 -90
)";

const std::string_view kDoorwaysWorld =
    R"(# Nine rooms of 3 x 3 m whose doorways are 0.55 to 0.60 m wide: a robot of 0.36 m fits through with a hand to spare.
room 0 0 0  9.2 9.2 2.5  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#9a8668 floor2=#8c795c ceiling=#f0eee6
box -4.045 -1.55 0  1.11 0.1 2.5  color=#d9c7a0
box -3.2 -1.55 2.05  0.58 0.1 0.45  color=#d9c7a0
box -1.393 -1.55 0  3.035 0.1 2.5  color=#d9c7a0
box 0.4 -1.55 2.05  0.55 0.1 0.45  color=#d9c7a0
box 2.637 -1.55 0  3.925 0.1 2.5  color=#d9c7a0
box -3.79 1.55 0  1.62 0.1 2.5  color=#c7d3b8
box -2.7 1.55 2.05  0.56 0.1 0.45  color=#c7d3b8
box 0.19 1.55 0  5.22 0.1 2.5  color=#c7d3b8
box 3.1 1.55 2.05  0.6 0.1 0.45  color=#c7d3b8
box 4 1.55 0  1.2 0.1 2.5  color=#c7d3b8
box -1.55 -4.2 0  0.1 0.8 2.5  color=#e3c3a0
box -1.55 -3.5 2.05  0.1 0.6 0.45  color=#e3c3a0
box -1.55 -2.4 0  0.1 1.6 2.5  color=#e3c3a0
box -1.55 -0.593 0  0.1 1.815 2.5  color=#b9cbb4
box -1.55 0.6 2.05  0.1 0.57 0.45  color=#b9cbb4
box -1.55 1.192 0  0.1 0.615 2.5  color=#b9cbb4
box -1.55 2.305 0  0.1 1.41 2.5  color=#c9b28f
box -1.55 3.3 2.05  0.1 0.58 0.45  color=#c9b28f
box -1.55 4.095 0  0.1 1.01 2.5  color=#c9b28f
box 1.55 -3.84 0  0.1 1.52 2.5  color=#d3b0a0
box 1.55 -2.8 2.05  0.1 0.56 0.45  color=#d3b0a0
box 1.55 -2.06 0  0.1 0.92 2.5  color=#d3b0a0
box 1.55 -1.15 0  0.1 0.7 2.5  color=#c4c09a
box 1.55 -0.5 2.05  0.1 0.6 0.45  color=#c4c09a
box 1.55 0.65 0  0.1 1.7 2.5  color=#c4c09a
box 1.55 2.013 0  0.1 0.825 2.5  color=#a9bdd2
box 1.55 2.7 2.05  0.1 0.55 0.45  color=#a9bdd2
box 1.55 3.787 0  0.1 1.625 2.5  color=#a9bdd2
box -4.2 -4.2 0  0.6 0.6 0.9  color=#d9c7a0
box 3.3 -3.3 0.7  0.8 0.8 0.04  color=#8a5a33
box 2.95 -3.65 0  0.06 0.06 0.7  color=#6b4423
box 2.95 -2.95 0  0.06 0.06 0.7  color=#6b4423
box 3.65 -3.65 0  0.06 0.06 0.7  color=#6b4423
box 3.65 -2.95 0  0.06 0.06 0.7  color=#6b4423
cylinder -3.6 0.9 0  0.2 0.8  color=#c7d3b8
box 0.4 0.7 0  0.5 0.4 0.6  30  color=#e3c3a0
box 4.2 0.3 0  0.5 1.2 1.2  color=#b9cbb4
shelves -3.2 4.35 0  1.2 0.34 1.8 5  color=#c9b28f
box 0.2 4.1 0  0.9 0.7 0.7  color=#d3b0a0
cylinder 4 3.9 0  0.25 1  color=#c4c09a
box 1 -4.3 0  0.7 0.4 0.8  color=#a9bdd2
start -2.6 -3 0
start 0 -0.5 90
start 3.2 3 180
)";

const std::string_view kLoopsWorld =
    R"(# Corridors of 1.6 m around three closed cores: loops that share their sides, and a dead end.
room 0 0 0  14.2 9.8 2.5  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#8f8a80 floor2=#7f7a72 ceiling=#f0eee6
# Cores
box -3.9 1.65 0  3.2 3.3 2.5  color=#d9c7a0 color2=#bda581 texture=stripes:0.5
box -3.9 -2.45 0  3.2 1.7 2.5  color=#c7d3b8 color2=#aebfa0 texture=checker:0.5
box 2.9 0 0  4.8 6.6 2.5  color=#e3c3a0 color2=#c2988e texture=stripes:0.7
# A dead end in the west and niches
box -6.85 0.8 0  0.5 0.1 2.5  color=#b9cbb4
box -6.75 3.2 0  0.7 0.5 1.2  color=#c9b28f
box 6.6 -3 0  1 0.5 0.8  color=#d3b0a0
cylinder 6.9 4.5 0  0.15 1  color=#c4c09a
cylinder -1.5 4.6 0  0.2 0.7  color=#a9bdd2
box 0.1 -4.65 0  1.2 0.35 0.5  color=#8a5a33
box 2.9 4.7 0  1.4 0.35 0.45  color=#8a5a33
box -3.9 -4.72 0.9  0.8 0.06 0.6  color=#2e6e4e
box 5.36 1.5 1  0.06 0.8 0.6  color=#c02040
box -1 -0.7 0  0.25 0.25 1.1  20  color=#d9c7a0
start -1 -2.5 90
start 6.2 0.5 -90
start -6.3 -1 90
start 2 4 0
)";

const std::string_view kMazeWorld =
    R"(# A maze of 7 x 7 cells of 1.25 m, walls of 8 cm; some walls are missing, so that there is more than one way.
room 0 0 0  8.75 8.75 2.2  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#b59a78 floor2=#a58a68 ceiling=#f0eee6
box -3.125 -1.875 0  0.08 2.58 2.2  color=#d9c7a0
box -3.125 3.75 0  0.08 1.33 2.2  color=#c7d3b8
box -1.875 -3.75 0  0.08 1.33 2.2  color=#e3c3a0
box -1.875 -1.25 0  0.08 1.33 2.2  color=#b9cbb4
box -1.875 2.5 0  0.08 1.33 2.2  color=#c9b28f
box -0.625 -2.5 0  0.08 1.33 2.2  color=#d3b0a0
box -0.625 1.25 0  0.08 3.83 2.2  color=#c4c09a
box 0.625 -3.75 0  0.08 1.33 2.2  color=#a9bdd2
box 0.625 -1.25 0  0.08 1.33 2.2  color=#d9c7a0
box 0.625 1.25 0  0.08 1.33 2.2  color=#c7d3b8
box 1.875 -2.5 0  0.08 1.33 2.2  color=#e3c3a0
box 1.875 2.5 0  0.08 1.33 2.2  color=#b9cbb4
box 3.125 1.25 0  0.08 1.33 2.2  color=#c9b28f
box 3.75 -3.125 0  1.17 0.08 2.2  color=#d3b0a0
box 1.25 -1.875 0  3.67 0.08 2.2  color=#c4c09a
box 2.5 -0.625 0  1.17 0.08 2.2  color=#a9bdd2
box -2.5 0.625 0  3.67 0.08 2.2  color=#d9c7a0
box 2.5 0.625 0  1.17 0.08 2.2  color=#c7d3b8
box -2.5 1.875 0  1.17 0.08 2.2  color=#e3c3a0
box 1.875 1.875 0  2.42 0.08 2.2  color=#b9cbb4
box -0.625 3.125 0  2.42 0.08 2.2  color=#c9b28f
start -3.75 -3.75 0
start 0 0 90
start 3.75 3.75 180
)";

}  // namespace g3d::hal
