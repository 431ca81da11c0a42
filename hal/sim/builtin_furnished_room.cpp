// SPDX-License-Identifier: Apache-2.0
// The furnished room and a drive through it: two rounds in a lane between the dining table and the furniture along the
// walls, looking around. Coordinates are chosen so that the drive keeps 0.3 m from everything.
#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {

const std::string_view kFurnishedRoomWorld =
    R"(# 10 x 10 x 2.5 m around the origin. A lane of about a metre, 2.5 m from the middle, stays clear.
# Shell
floor 0 0 0  10.3 10.3 0.15  color=#b98f5e color2=#a87f50 texture=checker:0.5
box 0 0 2.5  10.3 10.3 0.15  color=#f0eee6
box -5.075 0 0  0.15 10.3 2.5  color=#b9cbb4
box  5.075 0 0  0.15 10.3 2.5  color=#e3c3a0 color2=#d6b28a texture=stripes:0.4
box 0  5.075 0  10 0.15 2.5  color=#a9bdd2 color2=#9db2c8 texture=stripes:0.8
box 0 -5.075 0  10 0.15 2.5  color=#e6dcc0 color2=#dccfae texture=checker:0.25
box -4.99 0 0  0.02 10 0.1  color=#6a4c34
box  4.99 0 0  0.02 10 0.1  color=#6a4c34
box 0  4.99 0  9.96 0.02 0.1  color=#6a4c34
box 0 -4.99 0  9.96 0.02 0.1  color=#6a4c34
# Dining table with four chairs in the middle
box 0 0 0  2.6 2.2 0.012  color=#8c2f39 color2=#d9b44a texture=stripes:0.2
box 0 0 0.71  1.6 0.9 0.04  color=#8a5a33 color2=#7d5029 texture=stripes:0.1
box -0.74 -0.39 0  0.06 0.06 0.71  color=#6b4423
box  0.74 -0.39 0  0.06 0.06 0.71  color=#6b4423
box -0.74  0.39 0  0.06 0.06 0.71  color=#6b4423
box  0.74  0.39 0  0.06 0.06 0.71  color=#6b4423
sphere 0.2 0.05 0.84  0.09  color=#d94f30
cone -0.3 -0.1 0.75  0.05 0.22 0.09  color=#3c78a8
sphere -0.3 -0.1 1.05  0.13  color=#4f9a45
cylinder 0.5 -0.2 0.75  0.04 0.1  color=#f4f4f0
box -0.4 0.9 0.43  0.42 0.42 0.04 8  color=#c8553d
box -0.4 1.1 0.47  0.42 0.04 0.5 8  color=#c8553d
box -0.57 0.73 0  0.04 0.04 0.43 8  color=#5a4632
box -0.22 0.75 0  0.04 0.04 0.43 8  color=#5a4632
box -0.6 1.08 0  0.04 0.04 0.43 8  color=#5a4632
box -0.25 1.1 0  0.04 0.04 0.43 8  color=#5a4632
box 0.45 0.85 0.43  0.42 0.42 0.04 -5  color=#e0a030
box 0.45 1.05 0.47  0.42 0.04 0.5 -5  color=#e0a030
box 0.28 0.68 0  0.04 0.04 0.43 -5  color=#5a4632
box 0.62 0.66 0  0.04 0.04 0.43 -5  color=#5a4632
box 0.29 1.02 0  0.04 0.04 0.43 -5  color=#5a4632
box 0.64 1.0 0  0.04 0.04 0.43 -5  color=#5a4632
box -0.4 -0.9 0.43  0.42 0.42 0.04  color=#3f7f6b
box -0.4 -1.1 0.47  0.42 0.04 0.5  color=#3f7f6b
box -0.58 -0.72 0  0.04 0.04 0.43  color=#5a4632
box -0.22 -0.72 0  0.04 0.04 0.43  color=#5a4632
box -0.58 -1.08 0  0.04 0.04 0.43  color=#5a4632
box -0.22 -1.08 0  0.04 0.04 0.43  color=#5a4632
box 0.6 -1.15 0.43  0.42 0.42 0.04 25  color=#4b6ea8
box 0.68 -1.34 0.47  0.42 0.04 0.5 25  color=#4b6ea8
box 0.36 -1.06 0  0.04 0.04 0.43 25  color=#5a4632
box 0.69 -0.91 0  0.04 0.04 0.43 25  color=#5a4632
box 0.51 -1.39 0  0.04 0.04 0.43 25  color=#5a4632
box 0.84 -1.24 0  0.04 0.04 0.43 25  color=#5a4632
pole 0 0 2.05  0.01 0.45  color=#333333
cone 0 0 1.8  0.28 0.25 0.06  color=#e8c060
# West: sofa, coffee table with a glass top, floor lamp
box -4.5 0 0.08  0.9 2.2 0.34  color=#4d6d8f
box -4.85 0 0.42  0.2 2.2 0.45  color=#456483
box -4.5  1.2 0.08  0.9 0.2 0.55  color=#456483
box -4.5 -1.2 0.08  0.9 0.2 0.55  color=#456483
box -4.62 0.7 0.42  0.18 0.45 0.4 12  color=#e2b13c
box -4.62 -0.75 0.42  0.18 0.45 0.4 -10  color=#b5443c
box -3.85 0 0  1.3 1.9 0.012  color=#39575a color2=#cfd8d0 texture=checker:0.18
box -3.62 0 0.4  0.6 1.1 0.02  color=#9fd0d8 glass
box -3.62 0 0.12  0.5 1.0 0.02  color=#7a5230
pole -3.85 -0.48 0  0.02 0.4  color=#c0c0c4
pole -3.39 -0.48 0  0.02 0.4  color=#c0c0c4
pole -3.85 0.48 0  0.02 0.4  color=#c0c0c4
pole -3.39 0.48 0  0.02 0.4  color=#c0c0c4
box -3.7 0.2 0.14  0.22 0.3 0.05 20  color=#b03a5b
cylinder -4.6 1.75 0  0.16 0.03  color=#40403c
pole -4.6 1.75 0.03  0.0125 1.45  color=#d0b060
cone -4.6 1.75 1.42  0.22 0.28 0.12  color=#f6e3b0
box -4.985 -0.55 1.3  0.03 0.7 0.5  color=#d96b4a color2=#f0d9a0 texture=stripes:0.1
box -4.985 0.45 1.2  0.03 0.5 0.7  color=#2f5d73 color2=#8fc1b5 texture=checker:0.1
# South-west: tall plant, cupboard
cone -4.4 -3.2 0  0.18 0.4 0.25  color=#a5522d
cylinder -4.4 -3.2 0.4  0.03 0.5  color=#6b4b2a
sphere -4.4 -3.2 1.15  0.36  color=#3e8a3a
sphere -4.2 -3.0 1.5  0.24  color=#55a04a
sphere -4.6 -3.4 1.55  0.2  color=#347832
box -2.9 -4.7 0  1.2 0.5 1.9  color=#a86f3d color2=#9c6435 texture=stripes:0.6
sphere -2.97 -4.43 1.0  0.025  color=#e6d8a0
sphere -2.83 -4.43 1.0  0.025  color=#e6d8a0
box -2.9 -4.7 1.9  0.6 0.4 0.25 10  color=#c9a46a
cylinder -1.95 -4.7 0  0.17 0.45  color=#5c8a8a
# South: door, window, sideboard with flowers
box -0.6 -4.975 0  0.95 0.05 2.05  color=#7a4a28
sphere -0.25 -4.92 1.02  0.035  color=#e0c860
box 2.2 -4.98 1.0  1.8 0.04 1.2  color=#9fc9ea
box 2.2 -4.965 0.95  1.9 0.07 0.06  color=#fafaf5
box 2.2 -4.965 2.19  1.9 0.07 0.06  color=#fafaf5
box 1.28 -4.965 1.01  0.06 0.07 1.18  color=#fafaf5
box 3.12 -4.965 1.01  0.06 0.07 1.18  color=#fafaf5
box 2.2 -4.965 1.01  0.05 0.07 1.18  color=#fafaf5
box 2.2 -4.7 0.1  1.7 0.45 0.65  color=#f0ede2 color2=#dcd8c8 texture=stripes:0.425
box 1.45 -4.7 0  0.06 0.4 0.1  color=#40362c
box 2.95 -4.7 0  0.06 0.4 0.1  color=#40362c
cone 1.7 -4.7 0.75  0.06 0.18 0.1  color=#7d3f8c
sphere 1.7 -4.7 1.02  0.14  color=#d8557f
sphere 1.82 -4.62 0.98  0.08  color=#e88aa0
box 2.6 -4.7 0.75  0.3 0.2 0.22 15  color=#507a50
# South-east: desk with monitor, lamp and office chair, waste bin
box 4.6 -2.9 0.7  0.7 1.6 0.04  color=#c99b66
box 4.6 -3.68 0  0.66 0.04 0.7  color=#b58753
box 4.6 -2.12 0  0.66 0.04 0.7  color=#b58753
box 4.75 -2.9 0.84  0.05 0.6 0.36  color=#15171a dark
box 4.76 -2.9 0.74  0.04 0.06 0.12  color=#2a2c30
box 4.45 -2.95 0.74  0.16 0.42 0.025  color=#dddddd
cylinder 4.7 -3.5 0.74  0.08 0.02  color=#c03030
pole 4.7 -3.5 0.76  0.01 0.4  color=#c03030
cone 4.66 -3.5 1.12  0.1 0.12 0.03  color=#c03030
box 3.85 -2.85 0.45  0.46 0.46 0.07 30  color=#2f4858
box 3.63 -2.98 0.55  0.06 0.42 0.5 30  color=#2f4858
pole 3.85 -2.85 0.08  0.03 0.37  color=#8a8a90
cylinder 3.85 -2.85 0  0.26 0.08  color=#55565a
cylinder 4.6 -4.4 0  0.15 0.35  color=#b0b4b8
box 4.985 -2.9 1.4  0.03 1.0 0.6  color=#f2f2ee color2=#3b6ea5 texture=stripes:0.25
# East: stairs up to a landing
stairs 4.45 -0.9 0  1.0 0.26 0.17 7 90  color=#c2b59b color2=#a6987c texture=stripes:0.2
box 4.45 1.57 0  1.0 1.3 1.19  color=#b9ab8f
pole 3.98 -0.8 0  0.015 1.0  color=#444444
pole 3.98 0.9 1.19  0.015 0.9  color=#444444
pole 3.98 2.15 1.19  0.015 0.9  color=#444444
box 3.98 1.525 2.05  0.04 1.3 0.04  color=#6b4423
box 4.5 1.6 1.19  0.5 0.4 0.35 20  color=#b98a55
# North-east: television on a dark bench, loudspeakers, ball
box 3.3 4.72 0  1.7 0.45 0.42  color=#3c2f28
box 3.3 4.8 0.5  1.3 0.06 0.75  color=#101114 dark
box 3.3 4.8 0.42  0.4 0.2 0.08  color=#222428
box 2.25 4.75 0  0.25 0.25 0.95  color=#6b4a3a
box 4.4 4.75 0  0.25 0.25 0.95  color=#6b4a3a
sphere 2.25 4.62 0.7  0.09  color=#d8d8d0
sphere 4.4 4.62 0.7  0.09  color=#d8d8d0
sphere 4.1 3.75 0.15  0.15  color=#e05020
sphere 3.6 4.1 0.1  0.1  color=#3060c0
# North: two shelf units with books
shelves 0.6 4.8 0  1.2 0.36 1.9 6  color=#d8c49a
shelves -1.0 4.8 0  1.2 0.36 1.9 6  color=#d8c49a
box 0.6 4.985 0  1.2 0.03 1.9  color=#c2ad82
box -1.0 4.985 0  1.2 0.03 1.9  color=#c2ad82
box 0.3 4.82 0.02  0.5 0.24 0.27  color=#8f2d2d color2=#c9a227 texture=stripes:0.06
box 0.85 4.82 0.02  0.3 0.24 0.22  color=#2d4f8f color2=#5f86c4 texture=stripes:0.05
box 0.75 4.82 0.396  0.7 0.24 0.26  color=#2e6e4e color2=#a8c686 texture=stripes:0.07
sphere 0.25 4.8 0.5  0.1  color=#e3d26f
box 0.35 4.82 0.772  0.55 0.24 0.28  color=#7a3e7a color2=#d59bd5 texture=stripes:0.05
cylinder 0.9 4.8 0.772  0.08 0.2  color=#c9e3e8
box 0.65 4.82 1.148  0.9 0.24 0.25  color=#b5651d color2=#f0e0c0 texture=stripes:0.06
box 0.4 4.82 1.524  0.4 0.24 0.24  color=#20639b color2=#f6d55c texture=stripes:0.08
cone 0.9 4.8 1.524  0.07 0.24 0.02  color=#ed553b
box -0.8 4.82 0.02  0.6 0.26 0.3  color=#5b5b66
box -1.25 4.82 0.396  0.5 0.24 0.27  color=#b33951 color2=#91c7b1 texture=stripes:0.06
box -0.75 4.82 0.396  0.3 0.24 0.2  color=#e3d081
box -1.0 4.82 0.772  1.0 0.24 0.26  color=#3d5a80 color2=#ee6c4d texture=stripes:0.07
sphere -1.3 4.8 1.268  0.1  color=#8cb369
box -0.8 4.82 1.148  0.5 0.24 0.25  color=#6d597a color2=#e56b6f texture=stripes:0.05
box -1.1 4.82 1.524  0.7 0.24 0.22  color=#f4a259 color2=#5b8e7d texture=stripes:0.06
cone -1.0 4.8 1.9  0.1 0.15 0.13  color=#a5522d
sphere -1.0 4.8 2.14  0.17  color=#4f9a45
# North-west: bed, bedside table, coat stand
box -3.9 4.0 0.12  2.0 1.6 0.28  color=#8a6a4a
box -3.9 4.0 0.4  1.95 1.55 0.15  color=#f3f0ea
box -3.65 4.0 0.55  1.4 1.56 0.04  color=#5f7fb0 color2=#86a0c8 texture=stripes:0.2
box -4.65 4.4 0.55  0.35 0.6 0.12 5  color=#fdfdf8
box -4.65 3.6 0.55  0.35 0.6 0.12 -5  color=#fdfdf8
box -4.95 4.0 0  0.08 1.7 1.0  color=#6e5236
box -4.75 2.85 0  0.4 0.4 0.5  color=#9c7448
cone -4.75 2.85 0.5  0.1 0.22 0.05  color=#f2d2a9
cylinder -2.3 4.6 0  0.2 0.03  color=#38322c
pole -2.3 4.6 0.03  0.015 1.7  color=#38322c
sphere -2.3 4.6 1.78  0.12  color=#7c4f2f
cone -2.3 4.6 1.0  0.24 0.55 0.06  color=#8a3b3b
# Around the lane: free-standing thin poles, a pillar, cartons, a crate
pole -1.75 1.75 0  0.01 2.5  color=#f0c000
pole 1.75 1.8 0  0.0125 2.5  color=#c02040
pole 1.75 -1.75 0  0.015 2.5  color=#2040c0
pole -3.1 -3.3 0  0.01 1.2  color=#e07020
cylinder -1.8 -1.7 0  0.14 2.5  color=#d8d2c4 color2=#bfb7a4 texture=stripes:0.3
box 3.3 1.3 0  0.42 0.5 0.4 20  color=#c79a63
box 3.32 1.32 0.4  0.32 0.36 0.28 -12  color=#d3aa76
box 3.55 -1.3 0  0.3 0.3 0.3 45  color=#5fa08a
box 0.3 -4.4 0  0.5 0.4 0.3 -25  color=#b98a55
cone 3.4 -4.3 0  0.16 0.34 0.21  color=#b5532c
cone 3.4 -4.3 0.34  0.34 0.9 0  color=#2f7d3b
start -2.5 -2 90
start 2.5 0 -90
)";

const std::string_view kFurnishedRoomPath = R"(0.0 2.500 -1.600 0.50 28.0 12.6
1.0 2.500 -0.985 0.50 89.7 16.9
2.0 2.500 -0.370 0.50 15.1 -4.0
3.0 2.500 0.245 0.50 -31.0 -17.0
4.0 2.500 0.861 0.50 53.2 -1.5
5.0 2.500 1.476 0.50 81.7 17.9
6.0 2.369 2.067 0.50 22.8 10.5
7.0 1.902 2.448 0.50 52.3 -12.0
8.0 1.292 2.500 0.50 164.1 -13.9
9.0 0.677 2.500 0.50 154.4 7.8
10.0 0.062 2.500 0.50 64.3 18.7
11.0 -0.553 2.500 0.50 92.8 1.6
12.0 -1.168 2.500 0.50 177.0 -16.5
13.0 -1.782 2.481 0.50 142.6 -6.9
14.0 -2.298 2.168 0.50 107.2 15.2
15.0 -2.500 1.600 0.50 -152.0 14.8
16.0 -2.500 0.985 0.50 -90.3 -7.5
17.0 -2.500 0.370 0.50 -164.9 -16.3
18.0 -2.500 -0.245 0.50 149.0 2.3
19.0 -2.500 -0.861 0.50 -126.8 18.8
20.0 -2.500 -1.476 0.50 -98.3 7.1
21.0 -2.369 -2.067 0.50 -157.2 -14.3
22.0 -1.902 -2.448 0.50 -127.7 -11.5
23.0 -1.292 -2.500 0.50 -15.9 11.1
24.0 -0.677 -2.500 0.50 -25.6 17.7
25.0 -0.062 -2.500 0.50 -115.7 -2.2
26.0 0.553 -2.500 0.50 -87.2 -17.0
27.0 1.168 -2.500 0.50 -3.0 -3.3
28.0 1.782 -2.481 0.50 -37.4 17.2
29.0 2.298 -2.168 0.50 -72.8 12.1
30.0 2.500 -1.600 0.50 158.6 -0.0
31.0 2.500 -0.985 0.50 167.4 18.9
32.0 2.500 -0.370 0.50 130.4 4.0
33.0 2.500 0.245 0.50 71.9 -18.1
34.0 2.500 0.861 0.50 30.6 -7.7
35.0 2.500 1.476 0.50 34.0 16.5
36.0 2.369 2.067 0.50 111.0 11.2
37.0 1.902 2.448 0.50 -152.1 -14.1
38.0 1.292 2.500 0.50 -100.8 -14.1
39.0 0.677 2.500 0.50 -116.3 11.2
40.0 0.062 2.500 0.50 -168.6 16.5
41.0 -0.553 2.500 0.50 136.8 -7.7
42.0 -1.168 2.500 0.50 116.1 -18.1
43.0 -1.782 2.481 0.50 154.7 4.0
44.0 -2.298 2.168 0.50 -109.5 18.9
45.0 -2.500 1.600 0.50 -21.4 -0.0
46.0 -2.500 0.985 0.50 -12.6 -18.9
47.0 -2.500 0.370 0.50 -49.6 -4.0
48.0 -2.500 -0.245 0.50 -108.1 18.1
49.0 -2.500 -0.861 0.50 -149.4 7.7
50.0 -2.500 -1.476 0.50 -146.0 -16.5
51.0 -2.369 -2.067 0.50 -69.0 -11.2
52.0 -1.902 -2.448 0.50 27.9 14.1
53.0 -1.292 -2.500 0.50 79.2 14.1
54.0 -0.677 -2.500 0.50 63.7 -11.2
55.0 -0.062 -2.500 0.50 11.4 -16.5
56.0 0.553 -2.500 0.50 -43.2 7.7
57.0 1.168 -2.500 0.50 -63.9 18.1
58.0 1.782 -2.481 0.50 -25.3 -4.0
59.0 2.298 -2.168 0.50 70.5 -18.9
60.0 2.500 -1.600 0.50 158.6 -0.0
)";

}  // namespace g3d::hal
