// SPDX-License-Identifier: Apache-2.0
// The central promise: a walk whose map is far larger than the pools gives, paged-out blocks included, the very map
// that unlimited memory would have given.
#include "mapper/rolling_window.hpp"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <memory>

#include "hal/frame_pool.hpp"
#include "mapper/files/map_file.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/corridor_walk.hpp"
#include "tests/support/memory_page_file.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::mapper;
using tests::CorridorWalk;
using tests::MemoryPageFile;

namespace {

MapperConfig mapper_config(MapCapacity capacity, float resolution_m) {
  MapperConfig config;
  config.resolution_m = resolution_m;
  config.capacity = capacity;
  return config;
}

constexpr MapCapacity kPlenty{1U << 18, 1U << 17, 1U << 18};

/// A walk through the corridor, with a window if there is a page file for it.
struct Walk {
  explicit Walk(MapCapacity capacity, float resolution_m = 0.05F)
      : mapper(mapper_config(capacity, resolution_m), CorridorWalk::camera()),
        frame(hal::make_frame(CorridorWalk::camera())) {}

  void open_window(std::unique_ptr<PageFile> file, const WindowConfig& config = {}) {
    window = std::make_unique<RollingWindow>(mapper, CorridorWalk::camera(), config, std::move(file));
  }
  void step(const hal::Pose& pose) {
    walk.draw(pose, frame);
    if (window) window->prepare(pose);
    const FrameReport report = mapper.integrate(frame, pose);
    refused += report.refused_blocks;
    most_blocks = std::max(most_blocks, mapper.map().block_count());
  }
  void go(int frames) {
    for (int i = 0; i < frames; ++i) step(walk.pose(next_frame++));
  }
  std::string hash() {
    if (!window) return map_hash(mapper.map());
    window->finish();
    return map_hash(window->whole_map());
  }

  CorridorWalk walk;
  Mapper mapper;
  hal::Frame frame;
  std::unique_ptr<RollingWindow> window;
  std::uint64_t refused = 0;
  std::uint32_t most_blocks = 0;
  int next_frame = 0;
};

}  // namespace

TEST_CASE("a walk in a small pool with a window gives the map of a large pool", "[mapper][window][slow]") {
  const float resolution_m = GENERATE(0.05F, 0.1F);
  const double radius_m = GENERATE(0.0, 12.0);
  Walk unlimited(kPlenty, resolution_m);
  unlimited.go(400);
  const std::uint32_t all_blocks = unlimited.mapper.map().block_count();
  REQUIRE(unlimited.refused == 0);

  const test::TempFolder folder;
  const std::uint32_t blocks = all_blocks * 2 / 3;
  const MapCapacity small{blocks, blocks, blocks * 2};
  Walk without(small, resolution_m);
  without.go(400);
  REQUIRE(without.refused > 0);

  Walk paged(small, resolution_m);
  auto file = create_page_file(folder.path());
  REQUIRE(file.ok());
  paged.open_window(std::move(file).value(), {.radius_m = radius_m});
  paged.go(400);
  CHECK(paged.refused == 0);
  CHECK(paged.hash() == unlimited.hash());
  const WindowCounts& counts = paged.window->counts();
  CHECK(counts.regions_out > 10);
  CHECK(counts.regions_in > 10);
  CHECK(counts.late_regions == 0);
  CHECK(counts.failed_stores + counts.failed_loads + counts.no_room + counts.unmanaged_regions == 0);
  CHECK(paged.window->first_error().empty());
  CHECK(paged.window->store().region_count() > 0);
  CHECK(folder.listing().empty());  // the page file has no name

  // What is saved from both places is the file that unlimited memory would have saved.
  REQUIRE(save_map(unlimited.mapper.map(), {}, folder / "a.g3d").ok());
  REQUIRE(save_map(paged.window->whole_map(), {}, folder / "b.g3d").ok());
  CHECK(test::read_plain(folder / "a.g3d") == test::read_plain(folder / "b.g3d"));
  const auto size = measure(paged.window->whole_map());
  REQUIRE(size.ok());
  CHECK(size.value().counts.occupied == unlimited.mapper.map().counts().occupied);
  CHECK(size.value().counts.coloured == unlimited.mapper.map().counts().coloured);
}

TEST_CASE("the window shrinks before a pool refuses", "[mapper][window][slow]") {
  Walk unlimited(kPlenty);
  unlimited.walk.length_m = 64.0;
  unlimited.go(320);
  const std::uint32_t blocks = unlimited.mapper.map().block_count() / 4;
  Walk paged({blocks, blocks, blocks});
  paged.open_window(std::make_unique<MemoryPageFile>(), {.radius_m = 1000.0});
  paged.walk.length_m = 64.0;
  paged.go(320);
  CHECK(paged.refused == 0);
  CHECK(paged.most_blocks <= blocks);
  CHECK(paged.window->counts().smallest_radius_m < 100.0);
  CHECK(paged.window->counts().regions_out > 0);
  CHECK(paged.hash() == unlimited.hash());
}

TEST_CASE("nothing thrashes: a camera that stays or sways moves no region twice", "[mapper][window]") {
  Walk paged(kPlenty);
  paged.open_window(std::make_unique<MemoryPageFile>(), {.radius_m = 6.0});
  paged.go(130);
  for (int i = 0; i < 50; ++i) paged.step(paged.walk.pose(130));  // what is far has left
  const std::uint64_t out = paged.window->counts().regions_out;
  const std::uint64_t in = paged.window->counts().regions_in;
  REQUIRE(out > 0);
  for (int i = 0; i < 100; ++i) paged.step(paged.walk.pose(130 + i % 3));  // 0.4 m to and fro
  CHECK(paged.window->counts().regions_out <= out + 4);
  CHECK(paged.window->counts().regions_in <= in + 4);
}

TEST_CASE("jumps across the world find every region as it was left", "[mapper][window][slow]") {
  const std::uint64_t seed = GENERATE(1U, 2U, 3U);
  tests::Random random(seed);
  Walk unlimited(kPlenty, 0.1F);
  Walk paged(kPlenty, 0.1F);
  paged.open_window(std::make_unique<MemoryPageFile>(), {.radius_m = 0.0});
  for (int i = 0; i < 150; ++i) {
    const hal::Pose pose = unlimited.walk.pose(static_cast<int>(random.below(320)));
    unlimited.step(pose);
    paged.step(pose);
  }
  CHECK(paged.window->counts().regions_in > 100);
  CHECK(paged.hash() == unlimited.hash());
}

TEST_CASE("a frame outside of the grid moves nothing", "[mapper][window]") {
  Walk paged(kPlenty);
  paged.open_window(std::make_unique<MemoryPageFile>());
  paged.go(50);
  const std::uint32_t blocks = paged.mapper.map().block_count();
  paged.step(hal::from_xyz_rpy(1e6, 0, 0, 0, 0, 0));
  paged.step(hal::from_xyz_rpy(1e6, 0, 0, 0, 0, 0));
  CHECK(paged.mapper.map().block_count() == blocks);
  CHECK(paged.window->counts().regions_out == 0);
}

TEST_CASE("what a full disk does not take stays in memory", "[mapper][window][slow]") {
  Walk unlimited(kPlenty);
  unlimited.go(400);
  Walk paged(kPlenty);
  auto file = std::make_unique<MemoryPageFile>();
  file->full_at_bytes = GENERATE(0U, 100'000U);
  paged.open_window(std::move(file), {.radius_m = 0.0});
  paged.go(400);
  CHECK(paged.window->counts().failed_stores > 0);
  CHECK(paged.window->counts().failed_stores < 100);  // it is not tried every frame
  CHECK(paged.hash() == unlimited.hash());
  CHECK(paged.window->first_error().find("full") != std::string::npos);
}

TEST_CASE("a region that was spoiled on disk is reported, the others are there", "[mapper][window][slow]") {
  Walk paged(kPlenty);
  auto file = std::make_unique<MemoryPageFile>();
  MemoryPageFile& disk = *file;
  paged.open_window(std::move(file), {.radius_m = 0.0});
  paged.go(150);
  disk.spoil(40);
  paged.go(170);  // back to where it was
  CHECK(paged.window->counts().failed_loads == 1);
  paged.window->finish();
  CHECK(paged.window->first_error().find("checksum") != std::string::npos);
  const WindowedBlocks whole = paged.window->whole_map();
  const auto size = measure(whole);
  REQUIRE(size.ok());
  CHECK(whole.unreadable_regions() == 1);
  CHECK(size.value().counts.blocks > 500);
}

TEST_CASE("in real time the mapper never waits, and nothing is lost", "[mapper][window][threads]") {
  Walk unlimited(kPlenty);
  unlimited.go(130);
  Walk paged(kPlenty);
  auto file = std::make_unique<MemoryPageFile>();
  file->delay_us = GENERATE(0, 300);
  paged.open_window(std::move(file), {.radius_m = 0.0, .lockstep = false});
  paged.go(130);
  const std::string hash = paged.hash();
  const WindowCounts& counts = paged.window->counts();
  CHECK(counts.regions_out > 0);
  CHECK(counts.failed_stores + counts.failed_loads == 0);
  if (counts.late_regions == 0) CHECK(hash == unlimited.hash());
  const auto size = measure(paged.window->whole_map());
  REQUIRE(size.ok());
  const double known = static_cast<double>(size.value().counts.known());
  CHECK(known == Approx(static_cast<double>(unlimited.mapper.map().counts().known())).epsilon(0.02));
}

TEST_CASE("a region that changes while it is being stored stays as it is now", "[mapper][window][threads]") {
  Walk unlimited(kPlenty);
  Walk paged(kPlenty);
  auto file = std::make_unique<MemoryPageFile>();
  file->delay_us = 250'000;  // longer than the frames until it is here again, under sanitizers on a busy machine too
  paged.open_window(std::move(file), {.radius_m = 0.0, .lockstep = false});
  // Here, far away (what is here begins to leave), and here again before the disk is done.
  for (const int place : {0, 1, 2, 100, 2, 3, 4}) {
    unlimited.step(unlimited.walk.pose(place));
    paged.step(paged.walk.pose(place));
  }
  const std::string hash = paged.hash();
  CHECK(paged.window->counts().taken_back > 0);
  CHECK(paged.window->store().file_bytes() > 0);
  CHECK(hash == unlimited.hash());
}

TEST_CASE("a day of walking keeps memory flat", "[.soak][window]") {
  const auto resident_pages = [] {
    long total = 0;
    long resident = 0;
    std::FILE* file = std::fopen("/proc/self/statm", "r");
    REQUIRE(file != nullptr);
    REQUIRE(std::fscanf(file, "%ld %ld", &total, &resident) == 2);
    std::fclose(file);
    return resident;
  };
  const test::TempFolder folder;
  Walk paged({6000, 5000, 9000});
  paged.walk.length_m = 1000.0;
  auto file = create_page_file(folder.path());
  REQUIRE(file.ok());
  paged.open_window(std::move(file).value(), {.radius_m = 10.0});
  constexpr int kDay_frames = 24 * 3600;  // 24 h at 0.2 m/s, one frame a second
  paged.go(paged.walk.frames_per_turn());
  const long after_one_turn = resident_pages();
  paged.go(kDay_frames - paged.walk.frames_per_turn());
  const double page_mb = static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
  CHECK(static_cast<double>(resident_pages() - after_one_turn) * page_mb < 8.0);
  CHECK(paged.refused == 0);
  CHECK(paged.window->counts().late_regions == 0);
  CHECK(paged.window->store().file_bytes() < 2 * paged.window->store().live_bytes() + 1'000'000);
}
