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
};

}  // namespace g3d::mapper::cuda
