// SPDX-License-Identifier: Apache-2.0
// The thread that talks to the page store, so that the mapper never waits for a disk. Blocks travel in buffers that are
// allocated once; a buffer belongs to the mapper thread until it is submitted, and again once its result was taken.
//
//   mapper thread ──buffer + what to do──▶ pager thread ──buffer + how it went──▶ mapper thread
//
// store and load are answered questions. What is stored replaces nothing until commit; what was loaded stays on disk
// until drop: the mapper thread decides when it knows whether the map has changed meanwhile. As jobs are done in order,
// nothing has to be waited for before the next job on the same region.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hal/parking.hpp"
#include "hal/ring.hpp"
#include "mapper/page_store.hpp"

namespace g3d::mapper {

enum class PageJob : std::uint8_t {
  store,    ///< buffer's blocks -> new record, merged with the one on disk if there is one
  load,     ///< record -> buffer's blocks
  commit,   ///< the stored record counts
  abandon,  ///< the stored record is garbage
  drop,     ///< the loaded record is garbage
};

/// Blocks of one region on their way.
struct PageBuffer {
  RegionKey region = 0;
  std::uint32_t count = 0;
  PageRecord record;    ///< result of store
  MapCapacity freed{};  ///< what erasing these blocks from the map gives back
  std::array<StoredBlock, kRegionBlocks> blocks;

  [[nodiscard]] std::span<const StoredBlock> filled() const { return std::span(blocks).first(count); }
};

struct PageResult {
  PageJob job = PageJob::store;
  bool ok = false;
  std::uint32_t buffer = 0;
};

class Pager {
 public:
  /// Starts the thread.
  Pager(std::unique_ptr<PageFile> file, std::uint32_t max_regions, std::uint32_t buffers);
  ~Pager() { stop(); }
  Pager(const Pager&) = delete;
  Pager& operator=(const Pager&) = delete;

  // Mapper thread. Nothing here allocates or waits but wait_result() and stop().
  [[nodiscard]] bool try_acquire(std::uint32_t& buffer);
  void release(std::uint32_t buffer) { free_buffers_[free_count_++] = buffer; }
  [[nodiscard]] PageBuffer& operator[](std::uint32_t buffer) { return buffers_[buffer]; }
  void submit(PageJob job, std::uint32_t buffer);
  [[nodiscard]] bool try_result(PageResult& result);
  /// Only while a job is under way.
  void wait_result(PageResult& result);
  [[nodiscard]] std::uint32_t under_way() const { return under_way_; }
  [[nodiscard]] std::uint32_t free_buffers() const { return free_count_; }

  /// Finishes what was submitted and ends the thread. Results can still be taken, and jobs no longer be submitted.
  void stop();

  // After stop()
  [[nodiscard]] PageStore& store() { return store_; }
  /// What went wrong first; empty if nothing did.
  [[nodiscard]] const std::string& first_error() const { return first_error_; }
  // Any thread
  [[nodiscard]] std::uint64_t file_bytes() const { return file_bytes_.load(std::memory_order_relaxed); }

 private:
  struct Message {
    PageJob job;
    std::uint32_t buffer;
  };
  void loop();
  [[nodiscard]] hal::Result<void> work(PageJob job, PageBuffer& buffer);
  [[nodiscard]] hal::Result<void> store_blocks(PageBuffer& buffer);
  [[nodiscard]] hal::Result<void> load_blocks(PageBuffer& buffer);

  PageStore store_;
  std::unique_ptr<PageBuffer[]> buffers_;
  std::unique_ptr<std::uint32_t[]> free_buffers_;
  std::uint32_t free_count_;
  std::uint32_t under_way_ = 0;
  hal::Ring<Message> jobs_;
  hal::Ring<PageResult> results_;
  hal::Parking pager_parking_, mapper_parking_;
  std::vector<StoredBlock> merged_;  // pager thread
  std::string first_error_;          // pager thread
  std::atomic<std::uint64_t> file_bytes_{0};
  std::thread thread_;
};

}  // namespace g3d::mapper
