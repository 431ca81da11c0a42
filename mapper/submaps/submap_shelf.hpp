// SPDX-License-Identifier: Apache-2.0
// Where submaps lie that are not needed now: checksummed records in a page file. A record goes into the first gap that
// has room for it. What was written is read back before it counts. Thread: one at a time. Allocates.
//
//   record   u64 number, u32 bytes, u32 CRC of this and the bytes; bytes (submap_contents.hpp)
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/result.hpp"
#include "mapper/page_file.hpp"
#include "mapper/submaps/submap_contents.hpp"

namespace g3d::mapper::submaps {

struct ShelfCounts {
  std::uint64_t put_away = 0;
  std::uint64_t fetched = 0;
  std::uint64_t failed_stores = 0;  ///< those stay in memory
  std::uint64_t failed_loads = 0;   ///< what those held is lost
};

class SubmapShelf {
 public:
  using Number = std::uint64_t;
  static constexpr Number kNone = 0;

  explicit SubmapShelf(std::unique_ptr<PageFile> file) : file_(std::move(file)) {}

  /// The number under which it can be fetched, as often as one likes, until it is dropped. Errors: those of the file,
  /// bad_checksum.
  [[nodiscard]] hal::Result<Number> put(const SubmapContents& contents);
  /// Errors: not_found, those of the file, bad_checksum, malformed.
  [[nodiscard]] hal::Result<SubmapContents> fetch(Number number);
  void drop(Number number);

  [[nodiscard]] std::uint64_t file_bytes() const { return records_.empty() ? 0 : end_of(records_.back()); }
  [[nodiscard]] std::size_t size() const { return records_.size(); }
  /// Counted by those who put and fetch.
  [[nodiscard]] ShelfCounts& counts() { return counts_; }
  [[nodiscard]] const ShelfCounts& counts() const { return counts_; }
  /// What went wrong first; empty if nothing did.
  [[nodiscard]] const std::string& first_error() const { return first_error_; }
  /// Goes on with every use: what was used longest ago can be told.
  [[nodiscard]] std::uint64_t next_use() { return ++uses_; }

 private:
  struct Record {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
    Number number = kNone;
  };
  [[nodiscard]] static std::uint64_t end_of(const Record& record) { return record.offset + record.bytes; }
  [[nodiscard]] hal::Result<Bytes> read(const Record& record);
  template <typename Value>
  hal::Result<Value> noted(hal::Result<Value> result) {
    if (!result.ok() && first_error_.empty()) first_error_ = result.error().text;
    return result;
  }

  std::unique_ptr<PageFile> file_;
  std::vector<Record> records_;  ///< by offset
  Number next_number_ = 1;
  std::uint64_t uses_ = 0;
  ShelfCounts counts_;
  std::string first_error_;
};

}  // namespace g3d::mapper::submaps
