// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/row_workers.hpp"

#include <catch2/catch.hpp>
#include <vector>

using g3d::hal::RowWorkers;

TEST_CASE("every row is worked on exactly once, round after round", "[threads]") {
  for (const int threads : {1, 2, 5}) {
    RowWorkers workers(threads);
    for (int round = 0; round < 200; ++round) {
      const int rows = round % 37;
      std::vector<int> visits(37, 0);
      workers.run(rows, [&](int row) { ++visits[static_cast<std::size_t>(row)]; });
      for (int row = 0; row < 37; ++row) REQUIRE(visits[static_cast<std::size_t>(row)] == (row < rows ? 1 : 0));
    }
  }
}
