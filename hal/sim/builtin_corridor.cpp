// SPDX-License-Identifier: Apache-2.0
// A closed corridor to drive round, for what must forget the past: rolling windows and paging.
#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {

const std::string_view kCorridorWorld =
    R"(# A loop of 60 m: corridors of 2 m width around a closed core of 18 x 8 m, 10 cm walls.
floor 0 0 0  22.2 12.2 0.15  color=#8f8a80 color2=#7f7a72 texture=checker:0.5
box 0 0 2.5  22.2 12.2 0.15  color=#ecebe4
box -11.05 0 0  0.1 12.2 2.5  color=#a9c0a6 color2=#9ab297 texture=stripes:0.5
box  11.05 0 0  0.1 12.2 2.5  color=#d3b0a0 color2=#c7a292 texture=stripes:0.5
box 0  6.05 0  22 0.1 2.5  color=#9db6c9 color2=#8ea8bc texture=stripes:1.0
box 0 -6.05 0  22 0.1 2.5  color=#c9b28f color2=#bda581 texture=stripes:1.0
box -8.95 0 0  0.1 8 2.5  color=#c4c09a
box  8.95 0 0  0.1 8 2.5  color=#b7a3c4
box 0  3.95 0  18 0.1 2.5  color=#d8d0c0 color2=#cbc2b0 texture=checker:0.5
box 0 -3.95 0  18 0.1 2.5  color=#c0d0d8 color2=#b0c2cb texture=checker:0.5
# Doors, pictures, pillars, things along the walls: places that can be told apart
box -8.00 4.02 0  0.9 0.04 2.05  color=#7a4a28
sphere -7.65 4.06 1.0  0.03  color=#e0c860
box -7.20 -4.02 0  0.9 0.04 2.05  color=#8f2d2d
sphere -6.85 -4.06 1.0  0.03  color=#e0c860
box -6.50 5.98 1.2  0.8 0.04 0.5  color=#2e6e4e color2=#f0e0c0 texture=stripes:0.1
box -7.60 -5.98 1.1  0.6 0.04 0.8  color=#5b5b66 color2=#d0e0f0 texture=checker:0.1
box -4.80 4.02 0  0.9 0.04 2.05  color=#2f5d73
sphere -4.45 4.06 1.0  0.03  color=#e0c860
box -4.00 -4.02 0  0.9 0.04 2.05  color=#2e6e4e
sphere -3.65 -4.06 1.0  0.03  color=#e0c860
box -3.30 5.98 1.2  0.8 0.04 0.5  color=#5b5b66 color2=#f0e0c0 texture=stripes:0.1
box -4.40 -5.98 1.1  0.6 0.04 0.8  color=#b5651d color2=#d0e0f0 texture=checker:0.1
box -1.60 4.02 0  0.9 0.04 2.05  color=#8f2d2d
sphere -1.25 4.06 1.0  0.03  color=#e0c860
box -0.80 -4.02 0  0.9 0.04 2.05  color=#5b5b66
sphere -0.45 -4.06 1.0  0.03  color=#e0c860
box -0.10 5.98 1.2  0.8 0.04 0.5  color=#b5651d color2=#f0e0c0 texture=stripes:0.1
box -1.20 -5.98 1.1  0.6 0.04 0.8  color=#7a4a28 color2=#d0e0f0 texture=checker:0.1
box 1.60 4.02 0  0.9 0.04 2.05  color=#2e6e4e
sphere 1.95 4.06 1.0  0.03  color=#e0c860
box 2.40 -4.02 0  0.9 0.04 2.05  color=#b5651d
sphere 2.75 -4.06 1.0  0.03  color=#e0c860
box 3.10 5.98 1.2  0.8 0.04 0.5  color=#7a4a28 color2=#f0e0c0 texture=stripes:0.1
box 2.00 -5.98 1.1  0.6 0.04 0.8  color=#2f5d73 color2=#d0e0f0 texture=checker:0.1
box 4.80 4.02 0  0.9 0.04 2.05  color=#5b5b66
sphere 5.15 4.06 1.0  0.03  color=#e0c860
box 5.60 -4.02 0  0.9 0.04 2.05  color=#7a4a28
sphere 5.95 -4.06 1.0  0.03  color=#e0c860
box 6.30 5.98 1.2  0.8 0.04 0.5  color=#2f5d73 color2=#f0e0c0 texture=stripes:0.1
box 5.20 -5.98 1.1  0.6 0.04 0.8  color=#8f2d2d color2=#d0e0f0 texture=checker:0.1
box 8.00 4.02 0  0.9 0.04 2.05  color=#b5651d
sphere 8.35 4.06 1.0  0.03  color=#e0c860
box 8.80 -4.02 0  0.9 0.04 2.05  color=#2f5d73
sphere 9.15 -4.06 1.0  0.03  color=#e0c860
box 9.50 5.98 1.2  0.8 0.04 0.5  color=#8f2d2d color2=#f0e0c0 texture=stripes:0.1
box 8.40 -5.98 1.1  0.6 0.04 0.8  color=#2e6e4e color2=#d0e0f0 texture=checker:0.1
cylinder -10.8 -3.0 0  0.15 2.5  color=#d8d2c4
cylinder -10.8 3.0 0  0.15 2.5  color=#d8d2c4
cylinder 10.8 -2.5 0  0.15 2.5  color=#d8d2c4
cylinder 10.8 2.5 0  0.15 2.5  color=#d8d2c4
cone -6.20 5.75 0  0.15 0.35 0.2  color=#a5522d
sphere -6.20 5.75 0.6  0.28  color=#3e8a3a
cone 3.40 -5.75 0  0.15 0.35 0.2  color=#7d3f8c
sphere 3.40 -5.75 0.6  0.28  color=#3e8a3a
cone 10.70 0.50 0  0.15 0.35 0.2  color=#3c78a8
sphere 10.70 0.50 0.6  0.28  color=#3e8a3a
box 5.2 5.7 0  1.4 0.4 0.45  color=#8a5a33
box -4.4 -5.72 0  1.2 0.4 0.45  color=#8a5a33
box -10.75 0.3 0  0.3 0.9 1.2  color=#5f6f7f
pole 7.5 5.6 0  0.0125 1.8  color=#c02040
pole -1.5 -5.6 0  0.01 2.5  color=#f0c000
sphere 0.5 5.75 0.15  0.15  color=#e05020
box -9.7 -5.65 0  0.4 0.4 0.4 25  color=#c79a63
start -9.3 -5 0
start 10 1 90
)";

const std::string_view kCorridorPath = R"(0.0 -9.300 -5.000 0.60 0.0 0.0
1.0 -8.320 -5.000 0.60 32.0 5.4
2.0 -7.340 -5.000 0.60 26.0 8.0
3.0 -6.360 -5.000 0.60 -10.8 6.5
4.0 -5.380 -5.000 0.60 -34.8 1.7
5.0 -4.400 -5.000 0.60 -17.5 -4.0
6.0 -3.420 -5.000 0.60 20.6 -7.6
7.0 -2.440 -5.000 0.60 34.2 -7.3
8.0 -1.460 -5.000 0.60 7.3 -3.3
9.0 -0.480 -5.000 0.60 -28.3 2.5
10.0 0.500 -5.000 0.60 -30.3 6.9
11.0 1.480 -5.000 0.60 3.7 7.8
12.0 2.460 -5.000 0.60 33.3 4.7
13.0 3.440 -5.000 0.60 23.4 -0.8
14.0 4.420 -5.000 0.60 -14.2 -5.9
15.0 5.400 -5.000 0.60 -35.0 -8.0
16.0 6.380 -5.000 0.60 -14.2 -5.9
17.0 7.359 -5.000 0.60 23.4 -0.8
18.0 8.339 -5.000 0.60 33.3 4.7
19.0 9.319 -5.000 0.60 5.2 7.8
20.0 9.993 -4.400 0.60 51.5 6.9
21.0 10.000 -3.420 0.60 61.7 2.5
22.0 10.000 -2.440 0.60 97.3 -3.3
23.0 10.000 -1.460 0.60 124.2 -7.3
24.0 10.000 -0.480 0.60 110.6 -7.6
25.0 10.000 0.500 0.60 72.5 -4.0
26.0 10.000 1.480 0.60 55.2 1.7
27.0 10.000 2.460 0.60 79.2 6.5
28.0 10.000 3.440 0.60 116.0 8.0
29.0 9.990 4.419 0.60 131.8 5.4
30.0 9.300 5.000 0.60 -180.0 0.0
31.0 8.320 5.000 0.60 148.0 -5.4
32.0 7.340 5.000 0.60 154.0 -8.0
33.0 6.360 5.000 0.60 -169.2 -6.5
34.0 5.380 5.000 0.60 -145.2 -1.7
35.0 4.400 5.000 0.60 -162.5 4.0
36.0 3.420 5.000 0.60 159.4 7.6
37.0 2.440 5.000 0.60 145.8 7.3
38.0 1.460 5.000 0.60 172.7 3.3
39.0 0.480 5.000 0.60 -151.7 -2.5
40.0 -0.500 5.000 0.60 -149.7 -6.9
41.0 -1.480 5.000 0.60 176.3 -7.8
42.0 -2.460 5.000 0.60 146.7 -4.7
43.0 -3.440 5.000 0.60 156.6 0.8
44.0 -4.420 5.000 0.60 -165.8 5.9
45.0 -5.400 5.000 0.60 -145.0 8.0
46.0 -6.380 5.000 0.60 -165.8 5.9
47.0 -7.359 5.000 0.60 156.6 0.8
48.0 -8.339 5.000 0.60 146.7 -4.7
49.0 -9.319 5.000 0.60 177.9 -7.8
50.0 -9.993 4.400 0.60 -67.9 -6.9
51.0 -10.000 3.420 0.60 -61.7 -2.5
52.0 -10.000 2.440 0.60 -97.3 3.3
53.0 -10.000 1.460 0.60 -124.2 7.3
54.0 -10.000 0.480 0.60 -110.6 7.6
55.0 -10.000 -0.500 0.60 -72.5 4.0
56.0 -10.000 -1.480 0.60 -55.2 -1.7
57.0 -10.000 -2.460 0.60 -79.2 -6.5
58.0 -10.000 -3.440 0.60 -116.0 -8.0
59.0 -9.990 -4.419 0.60 -112.2 -5.4
60.0 -9.300 -5.000 0.60 -0.0 -0.0
)";

}  // namespace g3d::hal
