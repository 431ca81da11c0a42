// SPDX-License-Identifier: Apache-2.0
// Where an update goes: the slot that does not run, and the book that says what is in it. Which updates are taken is
// one pure function; the rest does what the disk is asked for. One thread; blocks on the disk.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "hal/boot/slot_image.hpp"
#include "hal/boot/slot_store.hpp"
#include "net/update_wire.hpp"

namespace g3d::net {

/// None: it is to be installed; else why not. `running`: none if no slot runs.
[[nodiscard]] std::optional<UpdateEnd> judge_update(const hal::SlotBook& book, std::optional<hal::Slot> running,
                                                    const hal::SlotImageId& image, bool force);

struct UpdateTargetPaths {
  std::string book;                                ///< of the SlotStore
  std::array<std::string, hal::kSlotCount> slots;  ///< files or partitions
  std::optional<hal::Slot> running;
};

class UpdateTarget {
 public:
  explicit UpdateTarget(UpdateTargetPaths paths) : paths_(std::move(paths)), store_(paths_.book) {}

  /// What the greeting says of this machine; zeros where the book cannot be read.
  [[nodiscard]] UpdateGreeting standing() const;
  /// Judges; then the book knows that the slot holds nothing whole, and there is room. None: go on.
  [[nodiscard]] std::optional<UpdateEnd> begin(const hal::SlotImageId& image, bool force);
  /// False if the disk does not give these bytes.
  [[nodiscard]] bool read(std::uint64_t offset, std::span<std::uint8_t> bytes);
  [[nodiscard]] std::optional<UpdateEnd> write(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  [[nodiscard]] std::optional<UpdateEnd> sync();
  /// The image is whole and was read back: it is what starts next.
  [[nodiscard]] std::optional<UpdateEnd> finish(const hal::SlotImageId& image, bool force);
  /// What the disk said last, for the log.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  [[nodiscard]] UpdateEnd failed(const hal::Error& error);

  UpdateTargetPaths paths_;
  hal::SlotStore store_;
  std::optional<hal::Slot> target_;
  std::optional<hal::SlotImage> image_;
  std::string trouble_;
};

}  // namespace g3d::net
