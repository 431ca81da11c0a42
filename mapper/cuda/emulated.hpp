// SPDX-License-Identifier: Apache-2.0
// The kernels run by this processor, block by block in random order: what a card without a card would do. For tests
// and sanitizers; it is slow.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mapper/cuda/card.hpp"

namespace g3d::mapper::cuda {

class Emulated final : public Card {
 public:
  /// Sizes of a FrameBuilder. Different seeds, different orders.
  Emulated(const MemorySizes& sizes, std::span<const float> column_slope, std::span<const float> row_slope,
           std::span<const std::uint16_t> mask, std::uint64_t seed);

  [[nodiscard]] FrameInput& input() override { return *memory_.input; }
  [[nodiscard]] std::uint16_t* depth() override { return memory_.depth; }
  [[nodiscard]] std::uint8_t* rgb() override { return memory_.rgb; }
  [[nodiscard]] const Parcels& parcels() override { return parcels_; }
  [[nodiscard]] std::uint32_t room() const override { return static_cast<std::uint32_t>(heads_.size()); }
  [[nodiscard]] const Classes& classes() override { return classes_; }
  [[nodiscard]] std::uint32_t class_room() const override { return static_cast<std::uint32_t>(class_heads_.size()); }
  bool import_blocks(std::uint32_t count) override;
  bool begin_frame() override { return true; }
  bool finish_frame(FrameCounters& counters) override;
  bool send_blocks(std::uint32_t first) override;
  bool set_columns(const ColumnTables& tables) override;
  bool read_columns(std::uint32_t first) override;
  [[nodiscard]] const Columns& columns() override { return columns_; }
  [[nodiscard]] std::uint32_t column_room() const override { return sizes_.columns; }
  [[nodiscard]] const Queries& queries() override { return queries_; }
  [[nodiscard]] std::uint32_t ray_room() const override { return sizes_.rays; }
  [[nodiscard]] std::uint32_t look_room() const override { return sizes_.looks; }
  bool cast_rays(std::uint32_t count, float resolution_m) override;
  bool count_looks(std::uint32_t count, const LookModel& model) override;
  [[nodiscard]] const GridQuestion& grid_question() override { return grid_question_; }
  [[nodiscard]] std::uint32_t grid_room() const override { return sizes_.grid_cells; }
  bool spread_grid() override;
  [[nodiscard]] const Alignment& alignment() override { return alignment_; }
  [[nodiscard]] std::uint32_t surface_slots() const override { return sizes_.surface_slots; }
  bool import_cells(std::uint32_t first, std::uint32_t count) override;
  bool begin_fit() override { return true; }
  bool finish_fit() override;
  bool add_samples() override;

  [[nodiscard]] const Memory& memory() const { return memory_; }

 private:
  template <typename Kernel>
  void launch(int blocks, int threads, Kernel&& kernel);
  std::uint64_t next_random();
  void shuffle(std::vector<int>& order);

  MemorySizes sizes_;
  std::uint64_t random_;
  std::vector<std::byte> bytes_;
  Memory memory_{};
  std::vector<ParcelHead> heads_;
  std::vector<ParcelPlane> planes_;
  std::vector<ParcelBrick> bricks_;
  std::vector<ClassHead> class_heads_;
  std::vector<ClassPlane> class_planes_;
  Parcels parcels_{};
  Classes classes_{};
  Queries queries_{};
  Columns columns_{};
  GridQuestion grid_question_{};
  Alignment alignment_{};
};

}  // namespace g3d::mapper::cuda
