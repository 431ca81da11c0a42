// SPDX-License-Identifier: Apache-2.0
// What a card in random order says about the columns of changed blocks: bit by bit what the voxels say one by one.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <vector>

#include "mapper/map_hash.hpp"
#include "tests/support/emulated_mapper.hpp"
#include "tests/support/faulty_card.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

/// Any bits for any level, any kind for any layer.
ColumnTables random_tables(tests::Random& random, int voxels_per_cell) {
  ColumnTables tables{};
  tables.first_block_z = 4096 - 8;
  tables.last_block_z = 4096 + 5;
  tables.voxels_per_cell = voxels_per_cell;
  for (auto& layer : tables.kinds) {
    for (std::uint8_t& kind : layer) kind = static_cast<std::uint8_t>(random.below(kLayerKinds));
  }
  for (auto& row : tables.bits) {
    for (std::uint8_t& bits : row) bits = static_cast<std::uint8_t>(random.below(64) & random.below(64));
  }
  return tables;
}

std::vector<std::uint8_t> slow_cells(const VoxelMap& map, const ColumnTables& tables, BlockKey key) {
  std::vector<std::uint8_t> cells(cells_of(tables));
  std::vector<int> counted(cells.size());
  BlockValues values;
  (void)map.read_block(key, values);
  const int side = 8 / tables.voxels_per_cell;
  for (std::size_t place = 0; place < values.size(); ++place) {
    const VoxelIndex v = decode(place);
    const auto cell = static_cast<std::size_t>(v.y / tables.voxels_per_cell * side + v.x / tables.voxels_per_cell);
    const std::uint8_t bits =
        tables.bits[tables.kinds[column_layer(tables, key)][v.z]][level_of(values[place]) & kLevelMask];
    cells[cell] |= bits;
    counted[cell] += (bits & kCountedBit) != 0 ? 1 : 0;
  }
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] |= counted[i] > 1 ? kCountedBit << 1 : 0;
  return cells;
}

}  // namespace

TEST_CASE("columns from the card say what their voxels say", "[cuda][slow]") {
  tests::Random random(3);
  for (const int voxels_per_cell : {1, 2, 4, 8}) {
    const hal::CameraModel camera = test::small_camera(80);
    MapperConfig config;
    config.capacity = {1U << 15, 1U << 14, 1U << 15};
    test::EmulatedMapper emulated(config, camera, static_cast<std::uint64_t>(voxels_per_cell));
    CHECK(emulated.twin.changed_columns().cells_per_block == 0);
    const ColumnTables tables = random_tables(random, voxels_per_cell);
    emulated.twin.follow_columns(tables);
    std::size_t checked = 0;
    for (const auto& [frame, pose] : test::random_frames(camera, 4, 60)) {
      (void)emulated.integrate(frame, pose);
      const ChangedColumns columns = emulated.twin.changed_columns();
      std::vector<BlockKey> told(columns.keys.begin(), columns.keys.end());
      std::vector<BlockKey> changed;
      for (const std::uint32_t slot : emulated.twin.changed_slots()) {
        if (column_layer(tables, emulated.map.header(slot).key) >= 0) changed.push_back(emulated.map.header(slot).key);
      }
      REQUIRE(columns.cells_per_block == cells_of(tables));
      for (std::size_t i = 0; i < told.size(); ++i) {
        const std::uint8_t* cells = columns.cells + i * columns.cells_per_block;
        const std::vector<std::uint8_t> expected = slow_cells(emulated.map, tables, told[i]);
        REQUIRE(std::equal(expected.begin(), expected.end(), cells));
      }
      checked += told.size();
      std::sort(told.begin(), told.end());
      std::sort(changed.begin(), changed.end());
      CHECK(told == changed);
      emulated.new_card(checked);  // a new one is told as well what to read
    }
    CHECK(checked > emulated.card->column_room());  // more than one round
  }
}

TEST_CASE("a card whose columns fail or cannot be is lost with the frame") {
  const hal::CameraModel camera = test::small_camera(60);
  MapperConfig small_config;
  small_config.capacity = {1U << 14, 1U << 13, 1U << 14};
  const auto frames = test::random_frames(camera, 2, 12);
  ColumnTables tables{};
  tables.first_block_z = 4096 - 20;
  tables.last_block_z = 4096 + 20;
  tables.voxels_per_cell = 2;
  for (auto& layer : tables.kinds) std::fill(std::begin(layer), std::end(layer), std::uint8_t{1});
  for (std::uint8_t level = 17; level < kColumnLevels; ++level) tables.bits[1][level] = 1;
  using Lie = std::function<void(const cuda::Columns&)>;
  const std::vector<Lie> lies{
      {},
      [](const cuda::Columns& c) {
        c.keys[0] = encode({4096, 4096, 4096 + 21});
      },
      [](const cuda::Columns& c) { c.keys[1] = BlockKey{1} << 40; },
      [](const cuda::Columns& c) {
        c.keys[0] = encode({4096, 4096, 4096});
        c.cells[15] = 2;
      },
  };
  for (std::size_t fault = 0; fault < lies.size() + 1; ++fault) {
    INFO("fault " << fault);
    test::EmulatedMapper emulated(small_config, camera, 12);
    auto faulty = std::make_shared<test::FaultyCard>(emulated.card);
    emulated.twin.set_card(faulty);
    emulated.twin.follow_columns(tables);
    (void)emulated.integrate(frames[0].frame, frames[0].T_world_camera);
    CHECK_FALSE(emulated.twin.changed_columns().keys.empty());
    if (fault < lies.size()) faulty->spoil_columns = lies[fault];
    faulty->fails_to_answer = fault == lies.size();
    const std::string before = map_hash(emulated.map);
    FrameReport report;
    const auto geometry = cpu::frame_geometry(emulated.sensor, hal::to_transform(frames[1].T_world_camera));
    REQUIRE(geometry);
    CHECK(emulated.twin.integrate(frames[1].frame, *geometry, true, 2, report) == (fault == 0));
    CHECK((map_hash(emulated.map) == before) == (fault != 0));
  }
}
