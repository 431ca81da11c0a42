// SPDX-License-Identifier: Apache-2.0
// Saves beside a working writer: whole blocks only, nothing lost when the writer rests, errors that do not stop it.
#include "mapper/files/checkpoint.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <thread>

#include "tests/support/sample_maps.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::mapper;
using g3d::test::TempFolder;
using g3d::tests::random_map;
using g3d::tests::same_map;

namespace {

bool wait_for(const std::string& path) {
  for (int i = 0; i < 4000; ++i) {
    if (std::filesystem::exists(path)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

BlockValues filled(std::uint32_t n) {
  BlockValues values;
  const auto shade = static_cast<std::uint8_t>(n % 16 + 1);
  values.fill(make_rgbo(shade, shade, shade, static_cast<std::uint8_t>(17 + n % 16)) | kHasColourBit);
  return values;
}

}  // namespace

TEST_CASE("the snapshot of a map at rest is the map", "[checkpoint]") {
  const TempFolder folder;
  const auto map = random_map(11, 300);
  const auto saved = save_snapshot(*map, {}, folder / "map.g3d");
  REQUIRE(saved.ok());
  CHECK(saved.value().counts.occupied == map->counts().occupied);
  const auto loaded = load_map(folder / "map.g3d");
  REQUIRE(loaded.ok());
  CHECK(same_map(*loaded.value().map, *map));
}

TEST_CASE("a snapshot beside a working writer holds whole blocks", "[checkpoint][threads]") {
  const TempFolder folder;
  constexpr BlockKey kBlocks = 64;
  VoxelMap map(Grid{}, {kBlocks, kBlocks, kBlocks * kBricksPerBlock});
  for (BlockKey key = 0; key < kBlocks / 2; ++key) REQUIRE(map.write_block(key, filled(0)));
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    for (std::uint32_t n = 1; !stop.load(); ++n) {
      // The lower half changes, of the upper half one comes and another goes.
      (void)map.write_block(n % (kBlocks / 2), filled(n));
      (void)map.write_block(kBlocks / 2 + n % (kBlocks / 2), filled(n));
      (void)map.erase_block(kBlocks / 2 + (n + 7) % (kBlocks / 2));
    }
  });
  bool whole = true;
  for (int i = 0; i < 20; ++i) {
    const auto saved = save_snapshot(map, {}, folder / "map.g3d");
    const auto loaded = load_map(folder / "map.g3d");
    whole = whole && saved.ok() && loaded.ok();
    if (!whole) break;
    BlockValues values;
    for (BlockKey key = 0; key < kBlocks; ++key) {
      const bool found = loaded.value().map->read_stored_block(key, values);
      whole = whole && (found || key >= kBlocks / 2);
      if (found) whole = whole && values == filled(level_of(values[0]) - 17U);
    }
  }
  stop.store(true);
  writer.join();
  CHECK(whole);
}

TEST_CASE("checkpoints come again and again until stopped", "[checkpoint][threads]") {
  const TempFolder folder;
  const std::string path = folder / "map.g3d";
  const auto map = random_map(3, 50);
  Checkpoint checkpoint(*map, {.period_s = 0.01, .path = path, .meta = {}});
  REQUIRE(wait_for(path));
  std::filesystem::remove(path);
  REQUIRE(wait_for(path));
  checkpoint.stop();
  CHECK(checkpoint.saves() >= 2);
  CHECK(checkpoint.failed_saves() == 0);
  CHECK(folder.listing() == "map.g3d\n");
  std::filesystem::remove(path);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("stopping does not wait for the next checkpoint", "[checkpoint][threads]") {
  const auto map = random_map(3, 5);
  const auto start = std::chrono::steady_clock::now();
  Checkpoint checkpoint(*map, {.period_s = 3600.0, .path = "never_written.g3d", .meta = {}});
  checkpoint.stop();
  checkpoint.stop();
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(60));
  CHECK(checkpoint.saves() == 0);
  CHECK_FALSE(std::filesystem::exists("never_written.g3d"));
}

TEST_CASE("a checkpoint that cannot be written is counted and tried again", "[checkpoint][threads]") {
  const TempFolder folder;
  const auto map = random_map(3, 5);
  Checkpoint checkpoint(*map, {.period_s = 0.005, .path = folder.path() + "/nowhere/map.g3d", .meta = {}});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  checkpoint.stop();
  CHECK(checkpoint.saves() == 0);
  CHECK(checkpoint.failed_saves() >= 2);
  CHECK(checkpoint.first_error().find("nowhere/map.g3d") != std::string::npos);
}
