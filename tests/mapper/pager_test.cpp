// SPDX-License-Identifier: Apache-2.0
#include "mapper/pager.hpp"

#include <catch2/catch.hpp>

#include "tests/support/memory_page_file.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using tests::MemoryPageFile;

namespace {

void fill(PageBuffer& buffer, RegionKey region, Rgbo value, std::uint32_t count = 3) {
  buffer.region = region;
  buffer.count = count;
  for (std::uint32_t i = 0; i < count; ++i) {
    buffer.blocks[i].key = first_block(region) + i;
    buffer.blocks[i].values.fill(value);
  }
}

PageResult do_now(Pager& pager, PageJob job, std::uint32_t buffer) {
  pager.submit(job, buffer);
  PageResult result;
  pager.wait_result(result);
  return result;
}

}  // namespace

TEST_CASE("blocks go out and come back", "[mapper][paging][threads]") {
  Pager pager(std::make_unique<MemoryPageFile>(), 100, 4);
  std::uint32_t buffer = 0;
  REQUIRE(pager.try_acquire(buffer));
  fill(pager[buffer], 7, 3);
  CHECK(do_now(pager, PageJob::store, buffer).ok);
  CHECK(do_now(pager, PageJob::commit, buffer).ok);
  pager[buffer].count = 0;
  CHECK(do_now(pager, PageJob::load, buffer).ok);
  REQUIRE(pager[buffer].count == 3);
  CHECK(pager[buffer].blocks[2].key == first_block(7) + 2);
  CHECK(pager[buffer].blocks[2].values[100] == 3);
  CHECK(do_now(pager, PageJob::drop, buffer).ok);
  CHECK_FALSE(do_now(pager, PageJob::load, buffer).ok);
  pager.stop();
  CHECK(pager.store().region_count() == 0);
  CHECK_FALSE(pager.first_error().empty());
}

TEST_CASE("an abandoned record leaves the one before", "[mapper][paging][threads]") {
  Pager pager(std::make_unique<MemoryPageFile>(), 100, 4);
  std::uint32_t buffer = 0;
  REQUIRE(pager.try_acquire(buffer));
  fill(pager[buffer], 7, 3);
  CHECK(do_now(pager, PageJob::store, buffer).ok);
  CHECK(do_now(pager, PageJob::abandon, buffer).ok);
  pager.stop();
  CHECK(pager.store().region_count() == 0);
  CHECK(pager.store().live_bytes() == 0);
}

TEST_CASE("storing a region that is on disk merges the two", "[mapper][paging][threads]") {
  Pager pager(std::make_unique<MemoryPageFile>(), 100, 4);
  std::uint32_t buffer = 0;
  REQUIRE(pager.try_acquire(buffer));
  fill(pager[buffer], 7, 20, 2);
  CHECK(do_now(pager, PageJob::store, buffer).ok);
  CHECK(do_now(pager, PageJob::commit, buffer).ok);
  fill(pager[buffer], 7, 22, 4);
  CHECK(do_now(pager, PageJob::store, buffer).ok);
  CHECK(do_now(pager, PageJob::commit, buffer).ok);
  CHECK(do_now(pager, PageJob::load, buffer).ok);
  REQUIRE(pager[buffer].count == 4);
  CHECK(pager[buffer].blocks[1].values[0] == 26);
  CHECK(pager[buffer].blocks[3].values[0] == 22);
}

TEST_CASE("jobs on one region are done in order, however many are under way", "[mapper][paging][threads]") {
  auto file = std::make_unique<MemoryPageFile>();
  file->delay_us = 50;
  constexpr std::uint32_t kBuffers = 6;
  Pager pager(std::move(file), 100, kBuffers);
  tests::Random random(1);
  int stored = 0;
  int loaded = 0;
  std::vector<Rgbo> on_disk(10, kUnknownRgbo);
  std::vector<bool> busy(10, false);
  const auto handle = [&](const PageResult& result) {
    PageBuffer& buffer = pager[result.buffer];
    if (result.job == PageJob::store) {
      REQUIRE(result.ok);
      ++stored;
      busy[buffer.region] = false;
      on_disk[buffer.region] = buffer.blocks[0].values[0];
      pager.submit(PageJob::commit, result.buffer);
    } else if (result.job == PageJob::load) {
      REQUIRE(result.ok);
      ++loaded;
      busy[buffer.region] = false;
      CHECK(buffer.blocks[0].values[0] == on_disk[buffer.region]);
      on_disk[buffer.region] = kUnknownRgbo;
      pager.submit(PageJob::drop, result.buffer);
    } else {
      pager.release(result.buffer);
    }
  };
  PageResult result;
  for (int i = 0; i < 2000; ++i) {
    const RegionKey region = random.below(10);
    std::uint32_t buffer = 0;
    if (!busy[region] && pager.try_acquire(buffer)) {
      busy[region] = true;
      const bool is_out = on_disk[region] != kUnknownRgbo;
      if (!is_out) fill(pager[buffer], region, random.below(16));
      pager[buffer].region = region;
      pager.submit(is_out ? PageJob::load : PageJob::store, buffer);
    } else if (pager.under_way() > 0) {
      pager.wait_result(result);
      handle(result);
    }
  }
  while (pager.under_way() > 0) {
    pager.wait_result(result);
    handle(result);
  }
  CHECK(stored > 100);
  CHECK(loaded > 100);
  CHECK(pager.free_buffers() == kBuffers);
  pager.stop();
  CHECK(pager.store().region_count() == static_cast<std::uint32_t>(stored - loaded));
}

TEST_CASE("stopping finishes what was asked", "[mapper][paging][threads]") {
  auto file = std::make_unique<MemoryPageFile>();
  file->delay_us = 2000;
  Pager pager(std::move(file), 100, 4);
  for (RegionKey region = 0; region < 4; ++region) {
    std::uint32_t buffer = 0;
    REQUIRE(pager.try_acquire(buffer));
    fill(pager[buffer], region, 3);
    pager.submit(PageJob::store, buffer);
  }
  std::uint32_t none = 0;
  CHECK_FALSE(pager.try_acquire(none));
  pager.stop();
  PageResult result;
  for (int i = 0; i < 4; ++i) {
    REQUIRE(pager.try_result(result));
    CHECK(result.ok);
  }
  CHECK_FALSE(pager.try_result(result));
  CHECK(pager.under_way() == 0);
}
