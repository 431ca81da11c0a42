// SPDX-License-Identifier: Apache-2.0
// Alignment of a frame before it is integrated: its samples, the fit, and what they add to the surfaces.
#include "mapper/cuda/helper/card_session.hpp"

namespace g3d::mapper::cuda {
namespace {

constexpr unsigned kSampleThreads = 256;  // kPixelThreads and kParcelThreads of the kernels
constexpr unsigned kMatchThreads = 128;

CuDevicePointer at(const void* p) { return static_cast<CuDevicePointer>(reinterpret_cast<std::uintptr_t>(p)); }
unsigned tiles(unsigned size, unsigned tile) { return (size + tile - 1) / tile; }

}  // namespace

bool CardSession::import_cells(std::uint32_t first, std::uint32_t count) {
  const MemorySizes& sizes = control_->sizes;
  const std::uint32_t room = touched_room(tiles_of(sizes.width_px, sizes.height_px), sizes.surface_slots);
  if (count == 0 || count > room || first > sizes.surface_slots || count > sizes.surface_slots - first) return false;
  void* arguments[] = {&first, &count};
  return check(driver_.copy_to_card(at(memory_.align.parcel), shared<char>(control_->align_cells),
                                    count * sizeof(align::SurfaceCell)),
               "cells") &&
         ask(kImportCells, stream_, tiles(count, kSampleThreads), kSampleThreads, arguments) &&
         check(driver_.stream_synchronize(stream_), "cells");
}

/// Copies and launches, up to where the state is on its way back.
bool CardSession::launch_fit(int most_steps) {
  const MemorySizes& sizes = control_->sizes;
  const unsigned chunks = tiles(tiles_of(sizes.width_px, sizes.height_px), kSampleThreads);
  const std::uint64_t depth_at = reinterpret_cast<std::uintptr_t>(memory_.depth) - base_;
  const std::uint64_t depth_bytes = sizeof(std::uint16_t) * std::uint64_t{sizes.width_px} * sizes.height_px;
  bool ok = check(driver_.copy_to_card_async(at(memory_.align.question), shared<char>(control_->align_question),
                                             sizeof(AlignQuestion), stream_),
                  "question") &&
            check(driver_.copy_to_card_async(at(memory_.depth), shared<const char>(control_->input) + depth_at,
                                             depth_bytes, stream_),
                  "depths");
  for (const Question kernel : {kReadTiles, kFindSamples, kCountChosen, kChoose}) {
    ok = ok && ask(kernel, stream_, chunks, kSampleThreads, nullptr);
  }
  for (int step = 0; ok && step <= most_steps; ++step) {
    void* arguments[] = {&step};
    ok = ask(kMatchStep, stream_, kMostChosen / kMatchThreads, kMatchThreads, arguments);
  }
  return ok && check(driver_.copy_to_host_async(shared<char>(control_->align_state), at(memory_.align.state),
                                                sizeof(AlignState), stream_),
                     "state");
}

bool CardSession::fit_frame() {
  if (!wait_for_colours()) return false;
  const int most_steps = shared<const AlignQuestion>(control_->align_question)->fit.most_steps;
  if (control_->sizes.surface_slots == 0 || most_steps < 0 || most_steps > kMostFitSteps) return false;
  if (fit_graph_ == nullptr) {
    if (!capture(fit_graph_, [&] { return launch_fit(most_steps); })) return false;
    fit_graph_steps_ = most_steps;
  }
  const bool by_graph = fit_graph_ != nullptr && fit_graph_steps_ == most_steps;
  return check(driver_.event_record(events_[0], stream_), "event") &&
         (by_graph ? check(driver_.graph_launch(fit_graph_, stream_), "graph") : launch_fit(most_steps)) &&
         wait_timed(stream_);
}

bool CardSession::add_samples() {
  const MemorySizes& sizes = control_->sizes;
  const AlignQuestion& question = *shared<const AlignQuestion>(control_->align_question);
  const std::uint32_t swept_end = question.swept_end;
  if (sizes.surface_slots == 0 || question.swept_first > swept_end || swept_end > sizes.surface_slots) return false;
  const std::uint32_t all = tiles_of(sizes.width_px, sizes.height_px);
  const unsigned chunks = tiles(all, kSampleThreads);
  std::uint32_t room = touched_room(all, sizes.surface_slots);
  void* arguments[] = {&room};
  bool ok = check(driver_.event_record(events_[0], stream_), "event") &&
            check(driver_.copy_to_card_async(at(memory_.align.question), shared<char>(control_->align_question),
                                             sizeof(AlignQuestion), stream_),
                  "question") &&
            ask(kPlaceSamples, stream_, chunks, kSampleThreads, nullptr) &&
            ask(kLeadCells, stream_, chunks, kSampleThreads, nullptr) &&
            ask(kAddSamples, stream_, chunks, kSampleThreads, nullptr);
  if (ok && question.looks_at_map != 0) {
    ok =
        ask(kSweepCells, stream_, tiles(swept_end - question.swept_first + 1, kSampleThreads), kSampleThreads, nullptr);
  }
  ok = ok && ask(kExportCells, stream_, tiles(room, kSampleThreads), kSampleThreads, arguments) &&
       check(driver_.copy_to_host_async(shared<char>(control_->align_state), at(memory_.align.state),
                                        offsetof(AlignState, arrived), stream_),
             "state") &&
       wait_timed(stream_);
  std::uint32_t touched = shared<const AlignState>(control_->align_state)->touched;
  if (touched > room) touched = room;
  return ok &&
         (touched == 0 || fetch(control_->align_cells, memory_.align.parcel, touched * sizeof(align::SurfaceCell)));
}

}  // namespace g3d::mapper::cuda
