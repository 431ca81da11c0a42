// SPDX-License-Identifier: Apache-2.0
// The map in a card and its mirror, the host's VoxelMap, kept equal: what the host changes goes to the card before the
// next frame, what a frame changes comes back before the mirror is shown. The mirror changes only when a frame is
// wholly there, so that a card may be lost at any time and the CPU twin go on from the mirror, the frame in hand
// included. Thread: mapper thread.
// Full pools: each block has all that a frame says of it, or its levels without some of the colours, or is as before,
// and the last two are counted as refused. Threads race for the last slots, so which blocks these are differs from run
// to run and from the CPU twin. A frame without refused blocks makes the mirror what it makes of it anywhere; what was
// refused is not made up for.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cuda/card.hpp"
#include "mapper/cuda/frame_builder.hpp"
#include "mapper/mapper.hpp"
#include "mapper/pool.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::cuda {

/// Of the blocks that a frame changed.
struct ChangedClasses {
  std::span<const ClassHead> heads;
  std::span<const ClassPlane> planes;  ///< same index; meaningless where the head says that all voxels are alike
};

class Twin {
 public:
  /// All references outlive this. The card's map is empty; what the mirror holds already is sent before the first
  /// frame.
  Twin(const MapperConfig& config, const cpu::SensorGeometry& sensor, std::span<const std::uint16_t> scan_mask,
       VoxelMap& mirror);
  ~Twin();
  Twin(const Twin&) = delete;
  Twin& operator=(const Twin&) = delete;

  [[nodiscard]] const FrameBuilder& builder() const { return builder_; }
  /// From now on frames go there, to an empty map. nullptr: no longer.
  void set_card(std::shared_ptr<Card> card);
  [[nodiscard]] bool has_card() const { return card_ != nullptr; }

  /// begin() and finish(). False: the card is lost, and the mirror is what it was before.
  [[nodiscard]] bool integrate(const hal::Frame& frame, const cpu::FrameGeometry& geometry, bool with_colour,
                               std::uint32_t frame_number, FrameReport& report) {
    return begin(frame, geometry, with_colour, frame_number, report) && finish(report);
  }
  /// The card integrates the frame and tells the classes of what it changed; the mirror is still the frame before.
  [[nodiscard]] bool begin(const hal::Frame& frame, const cpu::FrameGeometry& geometry, bool with_colour,
                           std::uint32_t frame_number, FrameReport& report);
  /// The mirror becomes what the card's map is.
  [[nodiscard]] bool finish(FrameReport& report);
  /// From now on begin() also reads the columns of what changed.
  void follow_columns(const ColumnTables& tables);
  /// Between begin() and the next one.
  [[nodiscard]] ChangedColumns changed_columns() const;

  /// The card's map becomes what the mirror is. False: the card is lost.
  [[nodiscard]] bool send_changes();
  // Questions to the card's map, which is the mirror: not between begin() and finish(). False: the card is lost; what
  // it answered may be incomplete.
  [[nodiscard]] bool cast_rays(std::span<const BulkRay> rays, std::span<BulkHit> hits);
  [[nodiscard]] bool count_looks(const LookModel& model, std::span<Look> looks);

  /// Between begin() and the next one. Empty when there were too many for the memory shared with the card.
  [[nodiscard]] ChangedClasses changed_classes() const;
  [[nodiscard]] std::span<const std::uint32_t> changed_slots() const { return {changed_.data(), changed_count_}; }

 private:
  [[nodiscard]] bool read_columns();
  [[nodiscard]] bool send_keys(std::span<const BlockKey> keys);
  [[nodiscard]] bool forget_keys(std::span<const BlockKey> keys);
  /// Whatever a helper writes, nothing is read or written beside its place.
  [[nodiscard]] static bool are_sane(const Parcels& parcels, std::uint32_t count);
  [[nodiscard]] static bool are_sane(const Classes& classes, std::uint32_t count);
  [[nodiscard]] static bool are_sane(std::span<const BulkRay> rays, std::span<const BulkHit> hits);
  [[nodiscard]] static bool is_sane(const LookGain& gain, const Look& look, const LookModel& model);
  void keep(std::uint32_t count);
  void take(const Parcels& parcels, std::uint32_t count, FrameReport& report);

  FrameBuilder builder_;
  VoxelMap& mirror_;
  BlockJournal journal_;
  std::shared_ptr<Card> card_;
  bool card_is_empty_ = true;
  std::uint32_t frame_number_ = 0;
  std::uint32_t on_card_ = 0;  ///< blocks that the frame changed there
  std::vector<std::uint32_t> changed_;
  std::size_t changed_count_ = 0;
  // What came in several rounds, until the frame is wholly there
  ReservedArray<ParcelHead> kept_heads_;
  ReservedArray<ParcelPlane> kept_planes_;
  ReservedArray<ParcelBrick> kept_bricks_;
  std::uint32_t kept_ = 0;
  // Columns, if somebody follows them
  std::optional<ColumnTables> column_tables_;
  std::uint8_t column_bits_ = 0;  ///< that a cell may have
  bool card_knows_columns_ = false;
  ReservedArray<BlockKey> column_keys_;
  ReservedArray<std::uint8_t> column_cells_;
  std::size_t column_count_ = 0;
};

}  // namespace g3d::mapper::cuda
