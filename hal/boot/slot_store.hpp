// SPDX-License-Identifier: Apache-2.0
// Where the book of the slots is kept: a file, or a small partition, with two records 4 KiB apart, written in turn and
// synced. A power cut spoils at most the one that was being written; the other is what held before. Changes are made
// under a lock, as the first process and the one that takes updates both make them. Any thread; blocks on the disk.
#pragma once

#include <functional>
#include <string>

#include "hal/boot/slot_record.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

class SlotStore {
 public:
  static constexpr std::size_t kRecordDistance_bytes = 4096;

  /// `path`: a file in a folder that exists (made by the first change), or a block device of 8 KiB and more.
  explicit SlotStore(std::string path) : path_(std::move(path)) {}

  /// Errors: not_found, malformed (no record can be read: see lost_book), no_permission, io_error.
  [[nodiscard]] Result<SlotBook> read() const;
  /// Reads, changes and keeps; what it answers is on the disk. An unchanged book costs no write. Where no record can be
  /// read, the change begins with `if_lost`. Errors: those of the change, of the disk; then the old book holds.
  using Change = std::function<Result<SlotBook>(SlotBook)>;
  [[nodiscard]] Result<SlotBook> change(const Change& how, const SlotBook& if_lost = lost_book());

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// What the first process does at every boot.
struct SlotChoice {
  std::optional<Slot> slot;      ///< none: neither can be started
  std::optional<Slot> given_up;  ///< left for the other one, by this choice
  bool is_counted = false;       ///< false: the disk did not take the book (`trouble`), so a good system was chosen
  std::string trouble;           ///< empty, or what was wrong with the book, for the log
};

/// Plans the start and keeps it. Where it cannot be kept an untried system is started only if there is no good one: it
/// might hang for ever without being counted.
[[nodiscard]] SlotChoice choose_slot(SlotStore& store, const UnusableSlots& unusable = {});

}  // namespace g3d::hal
