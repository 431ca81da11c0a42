// SPDX-License-Identifier: Apache-2.0
// Wide places: a warehouse, an open hall, a lobby with people.
#include "hal/sim/builtin_texts.hpp"

namespace g3d::hal {

const std::string_view kWarehouseWorld =
    R"(# A warehouse of 16 x 11 m: racks with pallets in rows, aisles of 1.5 m, drums, a desk by the gate.
room 0 0 0  16 11 4  0.1  color=#b8bcc0 color2=#aab0b4 texture=stripes:0.5 floor=#8d8d88 floor2=#84847f ceiling=#f0eee6
shelves -5.1 -2.9 0  2.6 1 3 3  color=#d9c7a0
box -5.95 -2.9 0.02  0.559 0.8 0.472  color=#c79a63
box -5.95 -2.9 1.51  0.559 0.8 0.312  color=#b98a55
box -5.1 -2.9 1.51  0.637 0.8 0.612  color=#b98a55
box -4.25 -2.9 1.51  0.59 0.8 0.866  color=#b98a55
shelves -2.35 -2.9 0  2.6 1 3 3  color=#c7d3b8
box -3.2 -2.9 0.02  0.506 0.8 0.848  3  color=#c79a63
box -3.2 -2.9 1.51  0.506 0.8 0.486  color=#b98a55
box -1.5 -2.9 0.02  0.522 0.8 0.824  color=#c79a63
box -1.5 -2.9 1.51  0.522 0.8 0.584  color=#b98a55
shelves 0.4 -2.9 0  2.6 1 3 3  color=#e3c3a0
box -0.45 -2.9 1.51  0.522 0.8 0.48  color=#b98a55
box 1.25 -2.9 0.02  0.627 0.8 0.69  -4  color=#c79a63
box 1.25 -2.9 1.51  0.627 0.8 0.44  color=#b98a55
shelves 3.15 -2.9 0  2.6 1 3 3  color=#b9cbb4
box 2.3 -2.9 0.02  0.565 0.8 0.958  -4  color=#c79a63
box 3.15 -2.9 0.02  0.57 0.8 0.774  3  color=#c79a63
box 3.15 -2.9 1.51  0.57 0.8 0.704  color=#b98a55
box 4 -2.9 0.02  0.517 0.8 1.039  -4  color=#c79a63
box 4 -2.9 1.51  0.517 0.8 0.513  color=#b98a55
shelves -5.1 -0.3 0  2.6 1 3 3  color=#c9b28f
box -5.95 -0.3 0.02  0.687 0.8 0.624  3  color=#c79a63
box -5.95 -0.3 1.51  0.687 0.8 0.337  color=#b98a55
box -5.1 -0.3 0.02  0.557 0.8 0.936  color=#c79a63
box -5.1 -0.3 1.51  0.557 0.8 0.861  color=#b98a55
box -4.25 -0.3 0.02  0.573 0.8 0.418  color=#c79a63
shelves -2.35 -0.3 0  2.6 1 3 3  color=#d3b0a0
box -3.2 -0.3 1.51  0.739 0.8 0.473  color=#b98a55
box -2.35 -0.3 0.02  0.742 0.8 0.943  color=#c79a63
box -2.35 -0.3 1.51  0.742 0.8 0.415  color=#b98a55
box -1.5 -0.3 0.02  0.611 0.8 0.496  color=#c79a63
box -1.5 -0.3 1.51  0.611 0.8 0.306  color=#b98a55
shelves 3.15 -0.3 0  2.6 1 3 3  color=#c4c09a
box 2.3 -0.3 0.02  0.511 0.8 0.519  3  color=#c79a63
box 3.15 -0.3 0.02  0.643 0.8 0.708  color=#c79a63
box 3.15 -0.3 1.51  0.643 0.8 0.337  color=#b98a55
shelves -5.1 2.3 0  2.6 1 3 3  color=#a9bdd2
box -5.95 2.3 0.02  0.637 0.8 0.808  color=#c79a63
box -5.95 2.3 1.51  0.637 0.8 0.618  color=#b98a55
box -5.1 2.3 1.51  0.693 0.8 0.445  color=#b98a55
box -4.25 2.3 0.02  0.603 0.8 0.426  color=#c79a63
shelves -2.35 2.3 0  2.6 1 3 3  color=#d9c7a0
box -3.2 2.3 0.02  0.607 0.8 0.551  color=#c79a63
box -3.2 2.3 1.51  0.607 0.8 0.445  color=#b98a55
box -2.35 2.3 1.51  0.552 0.8 0.331  color=#b98a55
box -1.5 2.3 1.51  0.732 0.8 0.841  color=#b98a55
shelves 0.4 2.3 0  2.6 1 3 3  color=#c7d3b8
box -0.45 2.3 0.02  0.663 0.8 0.954  -4  color=#c79a63
box -0.45 2.3 1.51  0.663 0.8 0.558  color=#b98a55
box 0.4 2.3 1.51  0.732 0.8 0.478  color=#b98a55
box 1.25 2.3 0.02  0.618 0.8 1.03  -4  color=#c79a63
box 1.25 2.3 1.51  0.618 0.8 0.693  color=#b98a55
shelves 3.15 2.3 0  2.6 1 3 3  color=#e3c3a0
box 4 2.3 0.02  0.511 0.8 1.029  3  color=#c79a63
# Along the walls
cylinder -7.4 4.9 0  0.28 0.9  color=#2f5d73
cylinder -6.75 4.9 0  0.28 0.9  color=#8f2d2d
cylinder -6.1 4.9 0  0.28 0.9  color=#2f5d73
cylinder -5.45 4.9 0  0.28 0.9  color=#8f2d2d
cylinder -4.8 4.9 0  0.28 0.9  color=#2f5d73
box -1.5 4.8 0  1 0.8 0.15  color=#c79a63
box -0.1 4.8 0  1 0.8 0.5  color=#c79a63
box 1.3 4.8 0  1 0.8 0.85  color=#c79a63
box 2.7 4.8 0  1 0.8 1.2  color=#c79a63
box 6.8 -4.6 0.7  1.4 0.7 0.04  color=#8a5a33
box 6.15 -4.9 0  0.06 0.06 0.7  color=#6b4423
box 6.15 -4.3 0  0.06 0.06 0.7  color=#6b4423
box 7.45 -4.9 0  0.06 0.06 0.7  color=#6b4423
box 7.45 -4.3 0  0.06 0.06 0.7  color=#6b4423
box 6.8 -4.9 0.74  0.5 0.05 0.35  color=#303030
box 6.6 -3.95 0.43  0.42 0.42 0.04  color=#b9cbb4
box 6.6 -3.76 0.47  0.42 0.04 0.45  color=#b9cbb4
box 6.42 -4.13 0  0.04 0.04 0.43  color=#5a4632
box 6.42 -3.77 0  0.04 0.04 0.43  color=#5a4632
box 6.78 -4.13 0  0.04 0.04 0.43  color=#5a4632
box 6.78 -3.77 0  0.04 0.04 0.43  color=#5a4632
box -7.5 -4.6 0  0.8 1.2 1  color=#e0a030
box -7 -4.6 0  0.06 1.1 2  color=#505050
pole 5.9 4.2 0 0.08 4.0  color=#f0c000
pole 5.9 -1.6 0 0.08 4.0  color=#f0c000
start 4.5 -4.4 180
start -6.9 0.8 -90
start 6.8 2 90
start 0 3.7 0
)";

const std::string_view kHallWorld =
    R"(# An open hall of 16 x 12 m: farther across than the camera can measure, four pillars, benches along one wall.
room 0 0 0  16 12 3.5  0.1  color=#cdd3d8 color2=#bfc6cc texture=stripes:0.5 floor=#a89a86 floor2=#9a8c78 ceiling=#f0eee6
cylinder -3.5 -2.5 0  0.3 3.5  color=#d8d2c4
cylinder -3.5 2.5 0  0.3 3.5  color=#d8d2c4
cylinder 3.5 -2.5 0  0.3 3.5  color=#d8d2c4
cylinder 3.5 2.5 0  0.3 3.5  color=#d8d2c4
box -6 5.6 0.1  1.8 0.45 0.35  color=#8a5a33
box -2 5.6 0.1  1.8 0.45 0.35  color=#8a5a33
box 2 5.6 0.1  1.8 0.45 0.35  color=#8a5a33
box 6 5.6 0.1  1.8 0.45 0.35  color=#8a5a33
box 7.6 0 0  0.5 2.4 1.1  color=#5f6f7f
cylinder -7.5 -5.5 0  0.25 1.2  color=#d9c7a0
box 0 -5.7 0  2.5 0.4 1.8  color=#c7d3b8
start 0 0 0
start -6 -4 90
start 5.5 4 180
start 6 -4.5 -90
)";

const std::string_view kPeopleWorld =
    R"(# A lobby of 11 x 8 m with a bar, tables and three people who walk their rounds for ever.
room 0 0 0  11 8 2.8  0.1  color=#d8ccb0 color2=#cbbea0 texture=stripes:0.5 floor=#a08c70 floor2=#928064 ceiling=#f0eee6
box -4.6 2.6 0  0.7 2.4 1.1  color=#6b4a3a
box 2.6 2.4 0.7  1.2 0.8 0.04  color=#8a5a33
box 2.05 2.05 0  0.06 0.06 0.7  color=#6b4423
box 2.05 2.75 0  0.06 0.06 0.7  color=#6b4423
box 3.15 2.05 0  0.06 0.06 0.7  color=#6b4423
box 3.15 2.75 0  0.06 0.06 0.7  color=#6b4423
box 2.6 3.1 0.43  0.42 0.42 0.04  color=#d9c7a0
box 2.6 3.29 0.47  0.42 0.04 0.45  color=#d9c7a0
box 2.42 2.92 0  0.04 0.04 0.43  color=#5a4632
box 2.42 3.28 0  0.04 0.04 0.43  color=#5a4632
box 2.78 2.92 0  0.04 0.04 0.43  color=#5a4632
box 2.78 3.28 0  0.04 0.04 0.43  color=#5a4632
box 2.6 1.7 0.43  0.42 0.42 0.04  color=#c7d3b8
box 2.6 1.51 0.47  0.42 0.04 0.45  color=#c7d3b8
box 2.42 1.52 0  0.04 0.04 0.43  color=#5a4632
box 2.42 1.88 0  0.04 0.04 0.43  color=#5a4632
box 2.78 1.52 0  0.04 0.04 0.43  color=#5a4632
box 2.78 1.88 0  0.04 0.04 0.43  color=#5a4632
box 2.8 -2.4 0.7  0.9 0.9 0.04  color=#8a5a33
box 2.4 -2.8 0  0.06 0.06 0.7  color=#6b4423
box 2.4 -2 0  0.06 0.06 0.7  color=#6b4423
box 3.2 -2.8 0  0.06 0.06 0.7  color=#6b4423
box 3.2 -2 0  0.06 0.06 0.7  color=#6b4423
box 2.1 -2.4 0.43  0.42 0.42 0.04  color=#e3c3a0
box 1.91 -2.4 0.47  0.04 0.42 0.45  color=#e3c3a0
box 1.92 -2.58 0  0.04 0.04 0.43  color=#5a4632
box 1.92 -2.22 0  0.04 0.04 0.43  color=#5a4632
box 2.28 -2.58 0  0.04 0.04 0.43  color=#5a4632
box 2.28 -2.22 0  0.04 0.04 0.43  color=#5a4632
box 3.6 -2.4 0.43  0.42 0.42 0.04  color=#b9cbb4
box 3.79 -2.4 0.47  0.04 0.42 0.45  color=#b9cbb4
box 3.42 -2.58 0  0.04 0.04 0.43  color=#5a4632
box 3.42 -2.22 0  0.04 0.04 0.43  color=#5a4632
box 3.78 -2.58 0  0.04 0.04 0.43  color=#5a4632
box 3.78 -2.22 0  0.04 0.04 0.43  color=#5a4632
cylinder -1.2 0.2 0  0.25 2.8  color=#d8d2c4
shelves -2.5 -3.75 0  1.6 0.36 1.8 5  color=#c9b28f
box 5.1 0 0  0.6 1.6 0.8  color=#d3b0a0
cylinder -5.1 -3.5 0  0.2 0.5  color=#a5522d
box 0.6 -3.1 0  0.1 1.8 2.5  color=#c4c09a
box 0.9 3.7 0  1.6 0.45 0.45  color=#4d6d8f
person 1.75 0.22  0,-3.4,-2.6 8,-3.4,2.2 12,-0.2,2.4 18,-0.2,-1.5 24,-3.4,-2.6  color=#3c5a80 color2=#2f4866 texture=stripes:0.25
person 1.65 0.2  0,1.2,0.2 7,4.2,0.2 11,4.2,-3.2 15,1.4,-3.2 22,1.2,0.2  color=#80503c
person 1.85 0.24  0,4.3,3.2 10,4.3,1.0 20,1.0,1.0 32,4.3,1.0 40,4.3,3.2  color=#4f7a45
start -2 -1 0
start 4.4 -0.9 180
start -3 3.4 -90
)";

}  // namespace g3d::hal
