// SPDX-License-Identifier: Apache-2.0
// The card behind a helper process. Whether the process is missing a driver, dies or hangs: a call then returns false,
// within `patience` or as soon as the process is gone, and the card counts as lost.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "hal/clock.hpp"
#include "mapper/cuda/card.hpp"
#include "mapper/cuda/helper_protocol.hpp"

namespace g3d::mapper::cuda {

struct HelperSetup {
  std::span<const std::byte> program;  ///< the helper's executable
  std::string_view kernels;            ///< PTX
  MemorySizes sizes;
  std::uint32_t room = 32768;  ///< parcels in one go
  std::uint32_t class_room = 65536;
  std::span<const float> column_slope;
  std::span<const float> row_slope;
  std::span<const std::uint16_t> mask;
  std::uint32_t update_warps = 0;        ///< for measurements; see HelperControl
  std::uint32_t processors = 0;          ///< for measurements: multiprocessors of the card to use; 0: all
  hal::TimeNs patience_ns = 33'000'000;  ///< a frame's time: a helper that takes longer is taken for hung
};

class HelperProcess final : public Card {
 public:
  /// Starts the process and returns at once. nullptr and `problem` if the system cannot.
  [[nodiscard]] static std::unique_ptr<HelperProcess> start(const HelperSetup& setup, std::string& problem);
  ~HelperProcess() override;
  HelperProcess(const HelperProcess&) = delete;
  HelperProcess& operator=(const HelperProcess&) = delete;

  /// starting: ask again. failed: problem() says why.
  [[nodiscard]] HelperState state();
  /// Waits while it is starting, so long at most.
  HelperState wait_started(hal::TimeNs limit_ns);
  [[nodiscard]] std::string problem() const;
  [[nodiscard]] std::string card_name() const { return control_->card; }
  [[nodiscard]] std::uint64_t card_bytes() const { return control_->card_bytes; }
  [[nodiscard]] std::uint32_t processors() const { return control_->processors; }
  /// What was wanted and is not to be had; empty if nothing.
  [[nodiscard]] std::string note() const;
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Has the process end by itself, and waits until it has. False: it takes longer.
  bool end(hal::TimeNs patience_ns);
  /// Ends the process without waiting for it: the system may need long to take a card from it.
  void abandon() { waits_for_end_ = false; }

  [[nodiscard]] FrameInput& input() override { return *at<FrameInput>(control_->input); }
  [[nodiscard]] std::uint16_t* depth() override { return depth_; }
  [[nodiscard]] std::uint8_t* rgb() override { return rgb_; }
  [[nodiscard]] const Parcels& parcels() override { return parcels_; }
  [[nodiscard]] std::uint32_t room() const override { return room_; }
  [[nodiscard]] const Classes& classes() override { return classes_; }
  [[nodiscard]] std::uint32_t class_room() const override { return class_room_; }
  bool import_blocks(std::uint32_t count) override;
  bool begin_frame() override;
  bool finish_frame(FrameCounters& counters) override;
  bool send_blocks(std::uint32_t first) override;
  bool set_columns(const ColumnTables& tables) override;
  bool read_columns(std::uint32_t first) override;
  [[nodiscard]] const Columns& columns() override { return columns_; }
  [[nodiscard]] std::uint32_t column_room() const override { return column_room_; }
  [[nodiscard]] const Queries& queries() override { return queries_; }
  [[nodiscard]] std::uint32_t ray_room() const override { return ray_room_; }
  [[nodiscard]] std::uint32_t look_room() const override { return look_room_; }
  bool cast_rays(std::uint32_t count, float resolution_m) override;
  bool count_looks(std::uint32_t count, const LookModel& model) override;

  [[nodiscard]] const GridQuestion& grid_question() override { return grid_question_; }
  [[nodiscard]] std::uint32_t grid_room() const override { return grid_room_; }
  bool spread_grid() override;
  [[nodiscard]] const Alignment& alignment() override { return alignment_; }
  [[nodiscard]] std::uint32_t surface_slots() const override { return surface_slots_; }
  bool import_cells(std::uint32_t first, std::uint32_t count) override;
  bool begin_fit() override;
  bool finish_fit() override;
  bool add_samples() override;

  /// For measurements: begin_frame() asks for this instead, and stages_us() tells what it took.
  void set_frame_command(HelperCommand command) { frame_command_ = command; }
  [[nodiscard]] std::span<const float, kStages> stages_us() const {
    return std::span<const float, kStages>(control_->stage_us);
  }
  /// For tests: has the helper hang.
  bool ask(HelperCommand command, std::uint32_t count, hal::TimeNs patience_ns);

 private:
  bool post(HelperCommand command, std::uint32_t count);
  bool wait_answer(hal::TimeNs patience_ns);
  HelperProcess() = default;
  template <typename T>
  [[nodiscard]] T* at(std::uint64_t offset) const {
    return reinterpret_cast<T*>(reinterpret_cast<char*>(control_) + offset);
  }
  /// Is it gone, or going? A process that held a card takes its time to end; its side of the line closes at once.
  [[nodiscard]] bool has_ended();
  void fill(const HelperSetup& setup);
  [[nodiscard]] bool spawn(std::span<const std::byte> program, std::string& problem);

  hal::RealClock clock_;
  HelperControl* control_ = nullptr;
  std::size_t bytes_ = 0;
  int memory_file_ = -1;
  int line_ = -1;  ///< says nothing; closed at the other end when the helper dies
  pid_t pid_ = -1;
  bool ended_ = false;
  bool waits_for_end_ = true;
  std::uint32_t asked_ = 0;
  std::uint32_t room_ = 0;  ///< our own copy: the helper may write anything into the shared one
  std::uint32_t class_room_ = 0;
  std::uint32_t ray_room_ = 0;
  std::uint32_t column_room_ = 0;
  std::uint32_t grid_room_ = 0;
  std::uint32_t look_room_ = 0;
  std::uint32_t surface_slots_ = 0;
  std::uint16_t* depth_ = nullptr;
  std::uint8_t* rgb_ = nullptr;
  Parcels parcels_{};
  Classes classes_{};
  Queries queries_{};
  Columns columns_{};
  GridQuestion grid_question_{};
  Alignment alignment_{};
  hal::TimeNs patience_ns_ = 0;
  HelperCommand frame_command_ = HelperCommand::run_frame;
};

}  // namespace g3d::mapper::cuda
