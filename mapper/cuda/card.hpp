// SPDX-License-Identifier: Apache-2.0
// What a map in a card's memory can be asked for. Behind it stands the helper process with its driver, or the
// emulation.
#pragma once

#include <cstdint>

#include "mapper/cuda/memory.hpp"

namespace g3d::mapper::cuda {

class Card {
 public:
  virtual ~Card() = default;
  /// What the next frame takes with it: parameters (counters zero) and images. Filled by the caller.
  [[nodiscard]] virtual FrameInput& input() = 0;
  [[nodiscard]] virtual std::uint16_t* depth() = 0;
  [[nodiscard]] virtual std::uint8_t* rgb() = 0;
  /// Parcels, first from the host, then back to it: at most room() of them.
  [[nodiscard]] virtual const Parcels& parcels() = 0;
  [[nodiscard]] virtual std::uint32_t room() const = 0;
  /// Of the last frame's changed blocks: all of them, if there are at most so many.
  [[nodiscard]] virtual const Classes& classes() = 0;
  [[nodiscard]] virtual std::uint32_t class_room() const = 0;

  // False: the card is lost, and what it was asked for may have happened or not.
  /// Takes `count` parcels into its map; either all of them erase, or none does. 0: makes what earlier ones gave back
  /// ready to be taken by the next.
  virtual bool import_blocks(std::uint32_t count) = 0;
  /// Begins with the input; only the colours may still come.
  virtual bool begin_frame() = 0;
  /// The input is whole. Integrates it and sends classes.
  virtual bool finish_frame(FrameCounters& counters) = 0;
  /// Makes parcels of the changed blocks from number `first` on.
  virtual bool send_blocks(std::uint32_t first) = 0;

  /// How read_columns() is to read; at any time.
  virtual bool set_columns(const ColumnTables& tables) = 0;
  /// After a frame and before anything else changes the map: reads the changed blocks from number `first` on.
  virtual bool read_columns(std::uint32_t first) = 0;
  [[nodiscard]] virtual const Columns& columns() = 0;
  [[nodiscard]] virtual std::uint32_t column_room() const = 0;

  // Between frames
  /// Filled by the caller, up to the room for each; the answers stand in them until the next question.
  [[nodiscard]] virtual const Queries& queries() = 0;
  [[nodiscard]] virtual std::uint32_t ray_room() const = 0;
  [[nodiscard]] virtual std::uint32_t look_room() const = 0;
  virtual bool cast_rays(std::uint32_t count, float resolution_m) = 0;
  /// The gains must be zero.
  virtual bool count_looks(std::uint32_t count, const LookModel& model) = 0;

  // At any time; ask_grid.hpp knows how
  [[nodiscard]] virtual const GridQuestion& grid_question() = 0;
  [[nodiscard]] virtual std::uint32_t grid_room() const = 0;
  virtual bool spread_grid() = 0;

  // Before a frame, if it is to be aligned; align_twin.hpp knows how
  [[nodiscard]] virtual const Alignment& alignment() = 0;
  /// Of the table of surfaces; 0: frames are not aligned here.
  [[nodiscard]] virtual std::uint32_t surface_slots() const = 0;
  /// `count` cells from alignment() become those from slot `first` on. They must be all of the table in the end.
  virtual bool import_cells(std::uint32_t first, std::uint32_t count) = 0;
  /// Begins a fit: question and depth() may still come, while the card wakes up.
  virtual bool begin_fit() = 0;
  /// They are there.
  virtual bool finish_fit() = 0;
  /// Its samples are added, and what that has changed is in alignment().
  virtual bool add_samples() = 0;
};

}  // namespace g3d::mapper::cuda
