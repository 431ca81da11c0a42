// SPDX-License-Identifier: Apache-2.0
// Questions to the map in the card, between frames: copied there, answered by launches as in
// cuda/kernels/cast_rays.hpp, copied back.
#include "mapper/cuda/helper/card_session.hpp"

namespace g3d::mapper::cuda {
namespace {

constexpr unsigned kRayThreads = 128;  // kParcelThreads, kPixelThreads and kLookTile of the kernels
constexpr unsigned kLookThreads = 256;
constexpr unsigned kLookTile = 16;
constexpr unsigned kWaves = 4;        // shares are smaller than what fits at once: rays differ in length
constexpr std::uint64_t kMany = ~0U;  // tasks: as many blocks of threads as make sense

unsigned tiles(unsigned size, unsigned tile) { return (size + tile - 1) / tile; }
CuDevicePointer at(const void* p) { return static_cast<CuDevicePointer>(reinterpret_cast<std::uintptr_t>(p)); }

}  // namespace

bool CardSession::load_questions(CuHandle module) {
  constexpr const char* kQuestionNames[kQuestionCount] = {"cast_rays_kernel", "mark_looks_kernel",
                                                          "count_looks_kernel"};
  for (int i = 0; i < kQuestionCount; ++i) {
    if (!check(driver_.module_get_function(&questions_[i], module, kQuestionNames[i]), kQuestionNames[i])) return false;
    int blocks = 0;
    const int threads = static_cast<int>(i == kCastRays ? kRayThreads : kLookThreads);
    if (!check(driver_.max_active_blocks(&blocks, questions_[i], threads, 0), kQuestionNames[i])) return false;
    questions_at_once_[i] = static_cast<unsigned>(blocks) * processors_;
  }
  return true;
}

bool CardSession::ask(Question question, std::uint64_t tasks, unsigned threads, void** arguments) {
  const unsigned most = kWaves * questions_at_once_[question];
  const unsigned blocks = tasks < most ? static_cast<unsigned>(tasks) : most;
  return check(driver_.launch_kernel(questions_[question], blocks, 1, 1, threads, 1, 1, 0, stream_, arguments, nullptr),
               "launch");
}

bool CardSession::cast_rays(std::uint32_t count) {
  if (count == 0 || count > control_->sizes.rays) return false;
  float resolution_m = control_->look_model.resolution_m;
  void* arguments[] = {&resolution_m, &count};
  return check(driver_.copy_to_card_async(at(memory_.rays), shared<char>(control_->rays), count * sizeof(BulkRay),
                                          stream_),
               "rays") &&
         check(driver_.event_record(events_[0], stream_), "event") &&
         ask(kCastRays, tiles(count, kRayThreads), kRayThreads, arguments) && finish_question() &&
         fetch(control_->ray_hits, memory_.ray_hits, count * sizeof(BulkHit));
}

bool CardSession::count_looks(std::uint32_t count) {
  if (count == 0 || count > control_->sizes.looks) return false;
  LookModel model = control_->look_model;
  if (model.stride_px < 1 || model.width_px < 1 || model.height_px < 1) return false;
  const unsigned side = kLookTile * static_cast<unsigned>(model.stride_px);
  const std::uint64_t marks = std::uint64_t{count} * tiles(static_cast<unsigned>(model.width_px), side) *
                              tiles(static_cast<unsigned>(model.height_px), side);
  void* mark_arguments[] = {&model, &count};
  void* count_arguments[] = {&count};
  return check(driver_.copy_to_card_async(at(memory_.looks), shared<char>(control_->looks), count * sizeof(Look),
                                          stream_),
               "looks") &&
         check(driver_.event_record(events_[0], stream_), "event") &&
         ask(kMarkLooks, marks, kLookThreads, mark_arguments) &&
         ask(kCountLooks, kMany, kLookThreads, count_arguments) && finish_question() &&
         fetch(control_->looks, memory_.looks, count * sizeof(Look));
}

/// Waits for the answer, and tells what it took.
bool CardSession::finish_question() {
  float ms = 0.0F;
  const bool ok = check(driver_.event_record(events_[1], stream_), "event") &&
                  check(driver_.stream_synchronize(stream_), "question") &&
                  check(driver_.event_elapsed_time(&ms, events_[0], events_[1]), "event");
  control_->stage_us[0] = 1000.0F * ms;
  return ok && fetch(offsetof(HelperControl, refused_imports), &memory_.state->refused_imports, sizeof(std::uint32_t));
}

}  // namespace g3d::mapper::cuda
