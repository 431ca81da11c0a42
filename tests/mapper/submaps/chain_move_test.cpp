// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/chain_move.hpp"

#include <array>
#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

TEST_CASE("what was mapped while a submap lasted moves as it does, and what came before all of them does not") {
  const ChainMove move({10, 20}, {hal::from_xyz_rpy(1, 0, 0, 0, 0, 0), hal::from_xyz_rpy(2, 0, 0, 0, 0, 0)});
  CHECK(move.at(9).translation_m[0] == 0.0);
  CHECK(move.at(10).translation_m[0] == 1.0);
  CHECK(move.at(19).translation_m[0] == 1.0);
  CHECK(move.at(20).translation_m[0] == 2.0);
  CHECK(move.at(1000).translation_m[0] == 2.0);
  CHECK(move.newest().translation_m[0] == 2.0);
  CHECK(ChainMove().newest().translation_m[0] == 0.0);
  CHECK(ChainMove().at(5).rotation_xyzw[3] == 1.0);
}

TEST_CASE("a move leads from where a submap stands to where it is to stand") {
  std::array<Submap, 1> submaps;
  submaps[0].first_ns = 5;
  submaps[0].T_world_stored = hal::from_xyz_rpy(1, 2, 0, 0, 0, 0.5);
  const hal::Pose wanted = hal::from_xyz_rpy(-1, 0, 0, 0, 0, 0.7);
  const ChainMove move(submaps, std::array{wanted});
  const hal::Pose there = hal::compose(move.at(6), submaps[0].T_world_stored);
  for (std::size_t i = 0; i < 3; ++i) CHECK(there.translation_m[i] == Approx(wanted.translation_m[i]).margin(1e-12));
}
