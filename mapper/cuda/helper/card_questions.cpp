// SPDX-License-Identifier: Apache-2.0
// Questions to the map in the card, between frames: copied there, answered by launches in cuda/kernels,
// copied back.
#include "mapper/cuda/helper/card_session.hpp"

namespace g3d::mapper::cuda {
namespace {

constexpr unsigned kRayThreads = 128;  // kParcelThreads, kPixelThreads and kLookTile of the kernels
constexpr unsigned kLookThreads = 256;
constexpr unsigned kLookTile = 16;
constexpr unsigned kSpreadTile = 32;
constexpr std::uint32_t kRoundsTogether = 16;
constexpr unsigned kWaves = 4;        // shares are smaller than what fits at once: rays differ in length
constexpr unsigned kNonBlocking = 1;  // CU_STREAM_NON_BLOCKING
constexpr std::uint64_t kMany = ~0U;  // tasks: as many blocks of threads as make sense

unsigned tiles(unsigned size, unsigned tile) { return (size + tile - 1) / tile; }
CuDevicePointer at(const void* p) { return static_cast<CuDevicePointer>(reinterpret_cast<std::uintptr_t>(p)); }

}  // namespace

bool CardSession::load_questions(CuHandle module) {
  constexpr const char* kQuestionNames[kQuestionCount] = {
      "read_columns_kernel", "cast_rays_kernel",    "mark_looks_kernel",  "count_looks_kernel",
      "begin_spread_kernel", "spread_round_kernel", "read_tiles_kernel",  "find_samples_kernel",
      "count_chosen_kernel", "choose_kernel",       "match_step_kernel",  "place_samples_kernel",
      "lead_cells_kernel",   "add_samples_kernel",  "sweep_cells_kernel", "export_cells_kernel",
      "import_cells_kernel"};
  for (int i = 0; i < kQuestionCount; ++i) {
    if (!check(driver_.module_get_function(&questions_[i], module, kQuestionNames[i]), kQuestionNames[i])) return false;
    int blocks = 0;
    const int threads = static_cast<int>(i <= kCastRays || i == kMatchStep ? kRayThreads : kLookThreads);
    if (!check(driver_.max_active_blocks(&blocks, questions_[i], threads, 0), kQuestionNames[i])) return false;
    questions_at_once_[i] = static_cast<unsigned>(blocks) * processors_;
  }
  if (confined_) side_stream_ = stream_;  // everything goes there
  return confined_ || check(driver_.stream_create(&side_stream_, kNonBlocking), "stream");
}

bool CardSession::ask(Question question, CuHandle stream, std::uint64_t tasks, unsigned threads, void** arguments) {
  const unsigned most = kWaves * questions_at_once_[question];
  const unsigned blocks = tasks < most ? static_cast<unsigned>(tasks) : most;
  return check(driver_.launch_kernel(questions_[question], blocks, 1, 1, threads, 1, 1, 0, stream, arguments, nullptr),
               "launch");
}

bool CardSession::set_columns() {
  const std::int32_t voxels = control_->column_tables.voxels_per_cell;
  if (voxels != 1 && voxels != 2 && voxels != 4 && voxels != 8) return false;
  return check(driver_.copy_to_card(at(memory_.column_tables), &control_->column_tables, sizeof(ColumnTables)),
               "columns");
}

bool CardSession::read_columns(std::uint32_t first) {
  std::uint32_t room = control_->sizes.columns;
  const std::uint32_t changed = control_->counters.changed;
  std::uint64_t count = changed > first ? changed - first : 0;
  if (count > room) count = room;
  if (count == 0) return false;
  void* arguments[] = {&first, &room};
  // Parcels of the frame may still be under way: these need not wait for them.
  return check(driver_.stream_wait_event(side_stream_, classes_there_, 0), "event") &&
         check(driver_.event_record(events_[0], side_stream_), "event") &&
         ask(kReadColumns, side_stream_, (count + 3) / 4, kRayThreads, arguments) && finish_question(side_stream_) &&
         fetch(control_->column_keys, memory_.column_keys, count * sizeof(std::uint64_t)) &&
         fetch(control_->column_cells, memory_.column_cells, count * cells_of(control_->column_tables));
}

bool CardSession::cast_rays(std::uint32_t count) {
  if (count == 0 || count > control_->sizes.rays) return false;
  float resolution_m = control_->look_model.resolution_m;
  void* arguments[] = {&resolution_m, &count};
  return check(driver_.copy_to_card_async(at(memory_.rays), shared<char>(control_->rays), count * sizeof(BulkRay),
                                          stream_),
               "rays") &&
         check(driver_.event_record(events_[0], stream_), "event") &&
         ask(kCastRays, stream_, tiles(count, kRayThreads), kRayThreads, arguments) && finish_question(stream_) &&
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
         ask(kMarkLooks, stream_, marks, kLookThreads, mark_arguments) &&
         ask(kCountLooks, stream_, kMany, kLookThreads, count_arguments) && finish_question(stream_) &&
         fetch(control_->looks, memory_.looks, count * sizeof(Look));
}

/// Launches without work cost little, waiting for the card more: rounds go out in batches.
bool CardSession::spread_grid() {
  const GridSpread& asked = *shared<const GridSpread>(control_->spread);
  const auto columns = static_cast<std::uint64_t>(asked.columns);
  const auto rows = static_cast<std::uint64_t>(asked.rows);
  if (asked.columns < 1 || asked.rows < 1 || columns * rows > control_->sizes.grid_cells) return false;
  const std::uint64_t cells = columns * rows;
  const std::uint64_t tile_count = std::uint64_t{tiles(static_cast<unsigned>(asked.columns), kSpreadTile)} *
                                   tiles(static_cast<unsigned>(asked.rows), kSpreadTile);
  if (!check(driver_.copy_to_card_async(at(memory_.spread), &asked, sizeof asked, stream_), "grid") ||
      !check(driver_.copy_to_card_async(at(memory_.grid_costs), shared<char>(control_->grid_costs), cells, stream_),
             "grid") ||
      !check(driver_.event_record(events_[0], stream_), "event") ||
      !ask(kBeginSpread, stream_, tile_count, kLookThreads, nullptr)) {
    return false;
  }
  std::uint32_t round = 0;
  do {
    if (round > cells) return false;  // no grid needs so many
    for (std::uint32_t i = 0; i < kRoundsTogether; ++i, ++round) {
      void* arguments[] = {&round};
      if (!ask(kSpreadRound, stream_, tile_count, kLookThreads, arguments)) return false;
    }
    if (!finish_question(stream_) ||
        !fetch(offsetof(HelperControl, awake_tiles), memory_.awake_counts + round % 3, sizeof(std::uint32_t))) {
      return false;
    }
  } while (control_->awake_tiles != 0);
  return fetch(control_->grid_distances, memory_.grid_distances, cells * sizeof(std::uint32_t));
}

bool CardSession::wait_timed(CuHandle stream) {
  float ms = 0.0F;
  const bool ok = check(driver_.event_record(events_[1], stream), "event") &&
                  check(driver_.stream_synchronize(stream), "question") &&
                  check(driver_.event_elapsed_time(&ms, events_[0], events_[1]), "event");
  control_->stage_us[0] = 1000.0F * ms;
  return ok;
}

/// Waits for the answer, and tells what it took.
bool CardSession::finish_question(CuHandle stream) {
  return wait_timed(stream) &&
         fetch(offsetof(HelperControl, refused_imports), &memory_.state->refused_imports, sizeof(std::uint32_t));
}

}  // namespace g3d::mapper::cuda
