// SPDX-License-Identifier: Apache-2.0
// Regions of a map as compressed, checksummed records in a page file. Records are appended; when more than half of the
// file is garbage, what still counts is moved down. A record is current only once it was written, read back, and
// committed: until then the one before it stands.
//
//   record   "PAGE" u32 blocks, u64 region, u64 version, u32 payload bytes, u32 CRC of all this and the payload;
//   payload
//            (block_codec.hpp)
//
// The index is in memory and of a size fixed at start. Thread: one at a time.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/result.hpp"
#include "mapper/block_source.hpp"
#include "mapper/fixed_table.hpp"
#include "mapper/page_file.hpp"
#include "mapper/region.hpp"

namespace g3d::mapper {

/// Where a record lies, and what its blocks need in memory.
struct PageRecord {
  std::uint64_t offset = 0;
  std::uint64_t version = 0;
  std::uint32_t bytes = 0;  ///< header included
  std::uint16_t blocks = 0;
  std::uint16_t planes = 0;
  std::uint16_t colour_bricks = 0;

  [[nodiscard]] MapCapacity needed() const { return {blocks, planes, colour_bricks}; }
};

inline constexpr std::size_t kPageHeaderBytes = 32;

class PageStore {
 public:
  PageStore(std::unique_ptr<PageFile> file, std::uint32_t max_regions);
  ~PageStore();
  PageStore(const PageStore&) = delete;
  PageStore& operator=(const PageStore&) = delete;

  /// Writes `blocks` (1..512, ascending, all of `region`) and reads them back. Nothing changes until commit(); each
  /// record must be committed or abandoned. Errors: those of the file, bad_checksum, no_capacity (index full).
  [[nodiscard]] hal::Result<PageRecord> put(RegionKey region, std::span<const StoredBlock> blocks);
  void commit(RegionKey region, const PageRecord& record);
  void abandon(const PageRecord& record);

  /// The blocks of a region, valid until the next call. Errors: not_found, those of the file, bad_checksum, malformed.
  [[nodiscard]] hal::Result<std::span<const StoredBlock>> get(RegionKey region) const;
  [[nodiscard]] const PageRecord* find(RegionKey region) const { return index_.find(region); }
  /// Forgets a region. False if there is none.
  bool drop(RegionKey region);

  [[nodiscard]] std::vector<RegionKey> sorted_regions() const;
  [[nodiscard]] std::uint32_t region_count() const { return index_.size(); }
  [[nodiscard]] std::uint64_t block_count() const { return blocks_; }
  [[nodiscard]] std::uint64_t live_bytes() const { return live_bytes_; }
  [[nodiscard]] std::uint64_t file_bytes() const { return end_; }

 private:
  struct Work;
  [[nodiscard]] hal::Result<std::span<const std::uint8_t>> read_record(RegionKey region,
                                                                       const PageRecord& record) const;
  void forget(const PageRecord& record);
  void compact_if_worth_it();

  std::unique_ptr<PageFile> file_;
  FixedTable<PageRecord> index_;
  std::unique_ptr<Work> work_;
  std::uint64_t end_ = 0;         ///< of the last record
  std::uint64_t live_bytes_ = 0;  ///< of current and of uncommitted records
  std::uint64_t blocks_ = 0;      ///< of current records
  std::uint64_t next_version_ = 1;
  std::uint32_t uncommitted_ = 0;
};

}  // namespace g3d::mapper
