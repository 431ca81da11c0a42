// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/card_keeper.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <utility>

#include "mapper/cuda/carried.hpp"

namespace g3d::mapper::cuda {
namespace {

constexpr hal::TimeNs kStartLimit_ns = 30'000'000'000;  // a driver may have to compile the kernels first
constexpr std::uint32_t kFramesToRestart = 1;
constexpr std::uint32_t kMostFramesToRestart = 1024;  // a card that is lost again and again is left alone for longer

}  // namespace

CardKeeper::CardKeeper(const MapperConfig& config, const cpu::SensorGeometry& sensor,
                       std::span<const std::uint16_t> scan_mask, VoxelMap& mirror)
    : sensor_(sensor),
      patience_ns_(config.card_patience_ns),
      resolution_m_(config.resolution_m),
      twin_(config, sensor, scan_mask, mirror) {
  helper_ = HelperProcess::start(setup(), report_.problem);
  if (helper_ != nullptr) take_if_ready(helper_->wait_started(kStartLimit_ns));
  frames_until_start_ = 0;  // a driver that is not there now will not come
  if (helper_ != nullptr) starter_ = std::make_unique<HelperStarter>(setup());
}

HelperSetup CardKeeper::setup() const {
  return {.program = carried_helper(),
          .kernels = carried_kernels(),
          .sizes = twin_.builder().sizes(),
          .column_slope = sensor_.column_slope,
          .row_slope = sensor_.row_slope,
          .mask = twin_.builder().mask(),
          .patience_ns = patience_ns_};
}

void CardKeeper::come_back() {
  if (helper_ != nullptr) {
    take_if_ready(helper_->state());
  } else if (starter_ != nullptr && starter_->is_under_way()) {
    if (starter_->take(helper_, report_.problem) && helper_ == nullptr) start_later();
  } else if (frames_until_start_ > 0 && --frames_until_start_ == 0) {
    if (lost_process_ > 0 && waitpid(lost_process_, nullptr, WNOHANG) != 0) lost_process_ = -1;
    starter_->ask();
  }
}

void CardKeeper::take_if_ready(HelperState state) {
  if (state == HelperState::starting) return;
  if (state == HelperState::failed) {
    report_.problem = helper_->problem();
    helper_.reset();
    start_later();
    return;
  }
  report_.name = helper_->card_name();
  report_.memory_bytes = helper_->card_bytes();
  twin_.set_card(helper_);
  align_twin_.forget_card();
}

void CardKeeper::start_later() {
  frames_until_start_ = std::min(kFramesToRestart << std::min(troubles_++, 10U), kMostFramesToRestart);
}

void CardKeeper::lose() {
  ++report_.losses;
  lost_process_ = helper_->pid();
  report_.problem = helper_->problem();
  helper_->abandon();
  twin_.set_card(nullptr);
  helper_.reset();
  start_later();
}

bool CardKeeper::begin(const hal::Frame& frame, const cpu::FrameGeometry& geometry, bool with_colour,
                       std::uint32_t frame_number) {
  if (!twin_.has_card()) come_back();
  if (twin_.has_card()) {
    begun_ = {};
    if (twin_.begin(frame, geometry, with_colour, frame_number, begun_)) return true;
    lose();
  }
  ++report_.frames_on_cpu;
  return false;
}

bool CardKeeper::cast_rays(std::span<const BulkRay> rays, std::span<BulkHit> hits) {
  return answered(twin_.has_card() && twin_.cast_rays(rays, hits));
}

bool CardKeeper::count_looks(const LookModel& model, std::span<Look> looks) {
  return answered(twin_.has_card() && twin_.count_looks(model, looks));
}

bool CardKeeper::fit(const hal::Frame& frame, const align::SampleShape& shape, const align::SurfaceMap& mirror,
                     const align::FitQuestion& question, align::CardFit& fitted) {
  if (!twin_.has_card() || !AlignTwin::can(*helper_, shape, mirror, question)) return answered_fit(false);
  const bool is_fitted = align_twin_.fit(*helper_, frame, shape, mirror, question, fitted);
  if (!is_fitted) lose();
  return answered_fit(is_fitted);
}

bool CardKeeper::answered_fit(bool by_card) {
  ++(by_card ? report_.fits_on_card : report_.fits_on_cpu);
  return by_card;
}

bool CardKeeper::add(const hal::RigidTransform& T_world_camera, hal::TimeNs stamp_ns, bool looks_at_map,
                     align::SurfaceMap& mirror) {
  const bool is_added = twin_.has_card() && (!looks_at_map || twin_.send_changes()) &&
                        align_twin_.add(*helper_, T_world_camera, stamp_ns, looks_at_map, resolution_m_, mirror);
  if (!is_added && twin_.has_card()) lose();
  return is_added;
}

bool CardKeeper::answered(bool by_card) {
  if (!by_card && twin_.has_card()) lose();
  ++(by_card ? report_.questions_on_card : report_.questions_on_cpu);
  return by_card;
}

bool CardKeeper::finish(FrameReport& report) {
  if (twin_.finish(begun_)) {
    report = begun_;
    ++report_.frames_on_card;
    return true;
  }
  lose();
  ++report_.frames_on_cpu;
  return false;
}

}  // namespace g3d::mapper::cuda
