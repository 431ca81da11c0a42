// SPDX-License-Identifier: Apache-2.0
// Has frames integrated by a card while there is one, and sees to it that there is one again after it was lost. It
// never waits for that: until a new helper is ready, frames go to the CPU twin. Thread: mapper thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "mapper/align/fit_card.hpp"
#include "mapper/cuda/align_twin.hpp"
#include "mapper/cuda/helper_process.hpp"
#include "mapper/cuda/helper_starter.hpp"
#include "mapper/cuda/twin.hpp"
#include "mapper/mapper.hpp"

namespace g3d::mapper::cuda {

class CardKeeper final : public align::FitCard {
 public:
  /// Starts a helper and waits until it has loaded its driver, or says that there is none.
  CardKeeper(const MapperConfig& config, const cpu::SensorGeometry& sensor, std::span<const std::uint16_t> scan_mask,
             VoxelMap& mirror);

  /// See Twin::begin(). False: there is no card, or it was lost with this frame; the map is what it was, and the caller
  /// goes on.
  [[nodiscard]] bool begin(const hal::Frame& frame, const cpu::FrameGeometry& geometry, bool with_colour,
                           std::uint32_t frame_number);
  /// See Twin::finish(). After begin() returned true; false as there.
  [[nodiscard]] bool finish(FrameReport& report);
  void follow_columns(const ColumnTables& tables) { twin_.follow_columns(tables); }
  [[nodiscard]] ChangedColumns changed_columns() const { return twin_.changed_columns(); }
  /// See Twin. False: there is no card, or it was lost, and the CPU twin answers.
  [[nodiscard]] bool cast_rays(std::span<const BulkRay> rays, std::span<BulkHit> hits);
  [[nodiscard]] bool count_looks(const LookModel& model, std::span<Look> looks);
  void forget_surfaces() override { align_twin_.forget_card(); }
  // Between finish() and begin(), if the configuration has surface_slots
  [[nodiscard]] bool fit(const hal::Frame& frame, const align::SampleShape& shape, const align::SurfaceMap& mirror,
                         const align::FitQuestion& question, align::CardFit& fitted) override;
  [[nodiscard]] bool add(const hal::RigidTransform& T_world_camera, hal::TimeNs stamp_ns, bool looks_at_map,
                         align::SurfaceMap& mirror) override;
  [[nodiscard]] ChangedClasses changed_classes() const { return twin_.changed_classes(); }
  [[nodiscard]] std::span<const std::uint32_t> changed_slots() const { return twin_.changed_slots(); }
  [[nodiscard]] bool is_ready() const { return twin_.has_card(); }
  [[nodiscard]] const CardReport& report() const { return report_; }
  [[nodiscard]] int process() const { return helper_ != nullptr ? helper_->pid() : -1; }

 private:
  [[nodiscard]] HelperSetup setup() const;
  /// The next step of a card that is to come back.
  void come_back();
  void take_if_ready(HelperState state);
  void start_later();
  void lose();
  bool answered(bool by_card);
  bool answered_fit(bool by_card);

  const cpu::SensorGeometry& sensor_;
  hal::TimeNs patience_ns_;
  float resolution_m_;
  Twin twin_;
  AlignTwin align_twin_;
  std::shared_ptr<HelperProcess> helper_;
  std::unique_ptr<HelperStarter> starter_;  ///< for those after the first one, if that one found a card
  int lost_process_ = -1;                   ///< the last one that was lost, until the system has done away with it
  CardReport report_;
  FrameReport begun_;                     ///< of the frame in hand
  std::uint32_t troubles_ = 0;            ///< losses, and helpers that did not come up again
  std::uint32_t frames_until_start_ = 0;  ///< after one of them; 0: never again, or it is under way
};

}  // namespace g3d::mapper::cuda
