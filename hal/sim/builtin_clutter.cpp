// SPDX-License-Identifier: Apache-2.0
// Places that are hard to see: a cluttered laboratory, offices of glass and black furniture.
#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {

const std::string_view kLabWorld =
    R"(# A cluttered laboratory of 8 x 7 m: benches, stools, cables on drums, boxes, poles, things under tables.
room 0 0 0  8 7 2.7  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#9aa0a0 floor2=#8e9494 ceiling=#f0eee6
box -2.9 0.2 0.86  0.8 3 0.04  color=#8a5a33
box -3.25 -1.25 0  0.06 0.06 0.86  color=#6b4423
box -3.25 1.65 0  0.06 0.06 0.86  color=#6b4423
box -2.55 -1.25 0  0.06 0.06 0.86  color=#6b4423
box -2.55 1.65 0  0.06 0.06 0.86  color=#6b4423
box 0.2 0.9 0.86  2.4 0.8 0.04  color=#8a5a33
box -0.95 0.55 0  0.06 0.06 0.86  color=#6b4423
box -0.95 1.25 0  0.06 0.06 0.86  color=#6b4423
box 1.35 0.55 0  0.06 0.06 0.86  color=#6b4423
box 1.35 1.25 0  0.06 0.06 0.86  color=#6b4423
box 3.65 -1 0  0.6 3 0.9  color=#f4f1e8
shelves -1.5 3.25 0  1.8 0.4 2 5  color=#d9c7a0
shelves 1.2 3.25 0  1.6 0.4 2 5  color=#c7d3b8
cylinder 2.197 -2.638 0  0.114 0.554  color=#e3c3a0
sphere 0.682 -1.98 0.099  0.099  color=#b9cbb4
box 1.997 -0.647 0  0.308 0.193 0.131  61.641  color=#c9b28f
cylinder 0.827 2.147 0  0.131 0.218  color=#d3b0a0
box 2.384 -1.628 0  0.121 0.082 0.766  79.397  color=#c4c09a
pole 0.777 -0.511 0  0.029 1.42  color=#a9bdd2
pole -1.423 -2.68 0  0.022 1.396  color=#d9c7a0
pole -0.356 -2.765 0  0.023 0.666  color=#c7d3b8
box 1.565 0.459 0  0.155 0.094 0.212  40.935  color=#e3c3a0
box -2.407 -1.48 0  0.166 0.132 0.798  14.327  color=#b9cbb4
box 3.749 2.604 0  0.214 0.21 0.455  85.424  color=#c9b28f
box -2.267 0.197 0  0.191 0.163 0.681  55.421  color=#d3b0a0
pole 1.357 -2.746 0  0.028 1.347  color=#c4c09a
cylinder -3.374 3.177 0  0.248 0.748  color=#a9bdd2
cone -1.02 1.585 0  0.221 0.776 0.088  color=#d9c7a0
cylinder 3.156 -0.47 0  0.128 0.497  color=#c7d3b8
cone 2.645 0.671 0  0.105 0.598 0.042  color=#e3c3a0
box -2.916 1.88 0  0.153 0.126 0.166  21.408  color=#b9cbb4
pole 1.313 1.385 0  0.023 1.374  color=#c9b28f
sphere -0.623 0.261 0.147  0.147  color=#d3b0a0
box 0.119 3.176 0  0.329 0.268 0.5  79.951  color=#c4c09a
pole -1.734 0.972 0  0.02 1.685  color=#a9bdd2
sphere 3.144 -2.425 0.179  0.179  color=#d9c7a0
cylinder 1.448 -1.653 0  0.106 0.42  color=#c7d3b8
start -1 -1.2 0
start -3.3 -2.8 45
start 2.4 2.2 -90
)";

const std::string_view kGlassWorld =
    R"(# Offices of glass and black furniture: infrared passes the panes, except their frames, and dies on what is black.
room 0 0 0  10 7.5 2.7  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#8f8a86 floor2=#827d79 ceiling=#f0eee6
# Panes in frames that are visible at the floor and above
box -1.6 -2.475 0  0.06 2.55 0.14  color=#707880
box -1.6 -2.475 0.14  0.02 2.55 2.2  color=#9fd0d8 glass
box -1.6 -2.475 2.34  0.06 2.55 0.36  color=#707880
box -1.6 0.7 0  0.06 1.8 0.14  color=#707880
box -1.6 0.7 0.14  0.02 1.8 2.2  color=#9fd0d8 glass
box -1.6 0.7 2.34  0.06 1.8 0.36  color=#707880
box 2.4 0.9 0  1.6 0.06 0.14  color=#707880
box 2.4 0.9 0.14  1.6 0.02 2.2  color=#9fd0d8 glass
box 2.4 0.9 2.34  1.6 0.06 0.36  color=#707880
box 4.6 0.9 0  0.8 0.06 0.14  color=#707880
box 4.6 0.9 0.14  0.8 0.02 2.2  color=#9fd0d8 glass
box 4.6 0.9 2.34  0.8 0.06 0.36  color=#707880
box 1.6 2.325 0  0.06 2.85 0.14  color=#707880
box 1.6 2.325 0.14  0.02 2.85 2.2  color=#9fd0d8 glass
box 1.6 2.325 2.34  0.06 2.85 0.36  color=#707880
# One pane without any frame, and a glass table
box -3.4 1.6 0  2.4 0.02 2.7  color=#9fd0d8 glass
box 3.4 -2.2 0.42  1.2 0.7 0.02  color=#9fd0d8 glass
pole 2.9 -2.48 0 0.025 0.42  color=#c0c0c4
pole 2.9 -1.92 0 0.025 0.42  color=#c0c0c4
pole 3.9 -2.48 0 0.025 0.42  color=#c0c0c4
pole 3.9 -1.92 0 0.025 0.42  color=#c0c0c4
# Black: a sofa, two cabinets, a column
box 4.5 -2.2 0  0.8 1.8 0.7  color=#15171a dark
box -4.6 -1 0  0.6 1.2 1.1  color=#101114 dark
box 0 3.4 0  1.4 0.5 0.8  color=#121212 dark
cylinder 0.2 -0.6 0  0.22 2.7  color=#181818 dark
# Things that can be measured
box -3.4 -2.6 0.7  1.4 0.7 0.04  color=#8a5a33
box -4.05 -2.9 0  0.06 0.06 0.7  color=#6b4423
box -4.05 -2.3 0  0.06 0.06 0.7  color=#6b4423
box -2.75 -2.9 0  0.06 0.06 0.7  color=#6b4423
box -2.75 -2.3 0  0.06 0.06 0.7  color=#6b4423
box -3.4 -1.95 0.43  0.42 0.42 0.04  color=#d9c7a0
box -3.4 -1.76 0.47  0.42 0.04 0.45  color=#d9c7a0
box -3.58 -2.13 0  0.04 0.04 0.43  color=#5a4632
box -3.58 -1.77 0  0.04 0.04 0.43  color=#5a4632
box -3.22 -2.13 0  0.04 0.04 0.43  color=#5a4632
box -3.22 -1.77 0  0.04 0.04 0.43  color=#5a4632
box 3.4 2.7 0.7  1.2 0.7 0.04  color=#8a5a33
box 2.85 2.4 0  0.06 0.06 0.7  color=#6b4423
box 2.85 3 0  0.06 0.06 0.7  color=#6b4423
box 3.95 2.4 0  0.06 0.06 0.7  color=#6b4423
box 3.95 3 0  0.06 0.06 0.7  color=#6b4423
box 3.4 2.05 0.43  0.42 0.42 0.04  color=#c7d3b8
box 3.4 1.86 0.47  0.42 0.04 0.45  color=#c7d3b8
box 3.22 1.87 0  0.04 0.04 0.43  color=#5a4632
box 3.22 2.23 0  0.04 0.04 0.43  color=#5a4632
box 3.58 1.87 0  0.04 0.04 0.43  color=#5a4632
box 3.58 2.23 0  0.04 0.04 0.43  color=#5a4632
box -4.5 3.2 0  0.7 0.7 1.3  color=#e3c3a0
cylinder 1 -3.3 0  0.2 0.5  color=#b9cbb4
shelves -0.6 -3.5 0  1.2 0.36 1.8 5  color=#c9b28f
start 0.3 0.8 180
start -3.2 -0.6 90
start 3 -0.6 0
)";

}  // namespace g3d::hal
