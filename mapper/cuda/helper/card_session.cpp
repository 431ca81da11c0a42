// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/helper/card_session.hpp"

#include <time.h>

#include <cstring>

#include "mapper/cuda/helper/few_processors.hpp"
#include "mapper/cuda/helper/text.hpp"

namespace g3d::mapper::cuda {
namespace {

constexpr unsigned kPixelThreads = 256;  // as kernels/common.hpp has them
constexpr unsigned kUpdateThreads = 128;
constexpr unsigned kParcelThreads = 128;
constexpr unsigned kPoolShares = kShares;
constexpr unsigned kUpdateWaves = 4;   // shares are smaller than what fits at once: blocks of the map differ in cost
constexpr unsigned kFewBlocks = 500;   // of a frame's box, for each multiprocessor
constexpr int kColourSpins = 200'000;  // about a millisecond
constexpr int kColourNaps = 1000;      // of a tenth each
constexpr unsigned kSpin = 1;          // CU_CTX_SCHED_SPIN: a wait is a fraction of a millisecond
constexpr unsigned kDeviceMap = 2;     // CU_MEMHOSTREGISTER_DEVICEMAP
constexpr int kProcessorCount = 16;    // CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT
constexpr int kErrorLog = 5;           // CU_JIT_ERROR_LOG_BUFFER and its size
constexpr int kErrorLogBytes = 6;

unsigned tiles(unsigned size, unsigned tile) { return (size + tile - 1) / tile; }

}  // namespace

bool CardSession::check(int result, const char* what) {
  if (result == 0) return true;
  const char* name = nullptr;
  if (driver_.get_error_name != nullptr) driver_.get_error_name(result, &name);
  if (control_->problem[0] == 0) put_text(control_->problem, sizeof control_->problem, what, ": ", name);
  return false;
}

bool CardSession::start(HelperControl& control) {
  control_ = &control;
  if (const char* missing = load_driver(driver_); missing != nullptr) {
    put_text(control.problem, sizeof control.problem, "no NVIDIA driver here: ", missing, " is missing");
    return false;
  }
  return make_context() && load_kernels() && make_memory() && make_graph(first_graph_, Part::until_colours) &&
         make_graph(last_graph_, Part::from_colours) && make_graph(launch_graph_, Part::launches_alone);
}

bool CardSession::make_context() {
  CuHandle context = nullptr;
  if (!check(driver_.init(0), "cuInit") || !check(driver_.device_get(&device_, 0), "cuDeviceGet")) return false;
  driver_.device_get_name(control_->card, sizeof control_->card, device_);
  int processors = 1;
  driver_.device_get_attribute(&processors, kProcessorCount, device_);
  processors_ = static_cast<unsigned>(processors);
  driver_.primary_context_set_flags(device_, kSpin);
  if (!check(driver_.primary_context_retain(&context, device_), "context") ||
      !check(driver_.context_set_current(context), "context")) {
    return false;
  }
  confined_ = control_->wanted_processors != 0 && confine(driver_, device_, *control_, stream_, processors_);
  control_->processors = processors_;
  // A frame finds work in about a third of its box: with less than some blocks of the map for every multiprocessor one
  // warp for each would leave most of the card idle.
  by_four_ =
      control_->update_warps == 0 ? control_->sizes.box_blocks < kFewBlocks * processors_ : control_->update_warps == 4;
  if ((!confined_ && !check(driver_.stream_create(&stream_, 1), "stream")) ||
      !check(driver_.event_create(&classes_there_, 0), "event")) {
    return false;
  }
  for (CuHandle& event : events_) {
    if (!check(driver_.event_create(&event, 0), "event")) return false;
  }
  return true;
}

bool CardSession::load_kernels() {
  static char log[200];
  int options[] = {kErrorLog, kErrorLogBytes};
  void* values[] = {log, reinterpret_cast<void*>(sizeof log)};
  CuHandle module = nullptr;
  const int loaded = driver_.module_load_data_ex(&module, shared<const char>(control_->program), 2, options, values);
  if (loaded != 0) put_text(control_->problem, sizeof control_->problem, "the driver refuses the kernels: ", log, "");
  if (!check(loaded, "module")) return false;
  constexpr const char* kNames[kKernelCount] = {"import_blocks_kernel",  "read_image_kernel",   "walk_image_kernel",
                                                "find_work_kernel",      "update_map_1_kernel", "update_map_4_kernel",
                                                "export_classes_kernel", "export_blocks_kernel"};
  for (int i = 0; i < kKernelCount; ++i) {
    if (!check(driver_.module_get_function(&kernels_[i], module, kNames[i]), kNames[i])) return false;
    const bool by_pixels = i == kRead || i == kWalk || i == kFind;
    int blocks = 0;
    if (!check(driver_.max_active_blocks(&blocks, kernels_[i], by_pixels ? kPixelThreads : kUpdateThreads, 0),
               kNames[i]))
      return false;
    at_once_[i] = static_cast<unsigned>(blocks) * processors_;
  }
  if (!load_questions(module)) return false;
  std::size_t map_bytes = 0;
  std::size_t params_bytes = 0;
  if (!check(driver_.module_get_global(&memory_symbol_, &map_bytes, module, "memory_map"), "memory_map") ||
      !check(driver_.module_get_global(&params_symbol_, &params_bytes, module, "frame_params"), "frame_params")) {
    return false;
  }
  if (map_bytes == sizeof(Memory) && params_bytes == sizeof(FrameParams)) return true;
  put_text(control_->problem, sizeof control_->problem, "kernels and helper are of different builds", "", "");
  return false;
}

bool CardSession::make_memory() {
  const MemorySizes& sizes = control_->sizes;
  // Where the card reaches host memory, parcels and counters are written there; else they are copied.
  CuDevicePointer mapped = 0;
  mapped_ = driver_.host_register(control_, control_->all_bytes, kDeviceMap) == 0 &&
            driver_.host_get_device_pointer(&mapped, control_, 0) == 0;
  control_->copies_parcels = mapped_ ? 0 : 1;
  const std::uint64_t class_heads_bytes = control_->class_planes - control_->class_heads;
  const std::uint64_t class_planes_bytes = control_->heads - control_->class_planes;
  const std::uint64_t heads_bytes = control_->planes - control_->heads;
  const std::uint64_t planes_bytes = control_->bricks - control_->planes;
  const std::uint64_t bricks_bytes = control_->all_bytes - control_->bricks;
  const std::uint64_t map_bytes = place(memory_, sizes, 0);
  const std::uint64_t own_bytes = aligned(sizeof(FrameCounters)) + class_heads_bytes + class_planes_bytes +
                                  heads_bytes + planes_bytes + bricks_bytes;
  control_->card_bytes = map_bytes + (mapped_ ? 0 : own_bytes);
  if (!check(driver_.mem_alloc(&base_, control_->card_bytes), "memory of the card")) return false;
  place(memory_, sizes, base_);
  CuDevicePointer first = base_ + map_bytes;
  card_counters_ = mapped_ ? mapped + offsetof(HelperControl, counters) : first;
  first += aligned(sizeof(FrameCounters));
  // The card's copy, or what it reaches of the host's.
  const auto take = [&](std::uint64_t offset, std::uint64_t bytes) {
    const CuDevicePointer at = mapped_ ? mapped + offset : first;
    first += bytes;
    return at;
  };
  classes_.heads = reinterpret_cast<ClassHead*>(take(control_->class_heads, class_heads_bytes));
  classes_.planes = reinterpret_cast<ClassPlane*>(take(control_->class_planes, class_planes_bytes));
  parcels_.heads = reinterpret_cast<ParcelHead*>(take(control_->heads, heads_bytes));
  parcels_.planes = reinterpret_cast<ParcelPlane*>(take(control_->planes, planes_bytes));
  parcels_.bricks = reinterpret_cast<ParcelBrick*>(take(control_->bricks, bricks_bytes));
  const MapState state = initial_state(sizes);
  const auto at = [](const auto* p) { return static_cast<CuDevicePointer>(reinterpret_cast<std::uintptr_t>(p)); };
  const std::uint64_t zeros = at(memory_.hits) - base_;
  return check(driver_.memset_d8(base_, 0, zeros), "memory of the card") &&
         check(driver_.memset_d8(at(memory_.hits), 0xFF, hits_bytes(sizes)), "memory of the card") &&
         check(driver_.copy_to_card(at(memory_.state), &state, sizeof state), "memory of the card") &&
         check(driver_.copy_to_card(at(memory_.column_slope), shared<const char>(control_->sensor),
                                    control_->sensor_bytes),
               "memory of the card") &&
         check(driver_.copy_to_card(memory_symbol_, &memory_, sizeof memory_), "memory of the card");
}

bool CardSession::make_graph(CuHandle& graph, Part part) {
  return capture(graph, [&] { return launch_part(part); });
}

bool CardSession::launch(Kernel kernel, unsigned blocks, unsigned threads, void** arguments) {
  return check(driver_.launch_kernel(kernels_[kernel], blocks, 1, 1, threads, 1, 1, 0, stream_, arguments, nullptr),
               "launch");
}

/// The same grids for every frame: blocks of threads stride over what there is.
bool CardSession::launch_step(int kernel) {
  const MemorySizes& s = control_->sizes;
  switch (static_cast<Kernel>(kernel)) {
    case kRead:
      return launch(kRead, 3 * kPoolShares + 2 * tiles(s.width_px, 32) * tiles(s.height_px, 32), kPixelThreads,
                    nullptr);
    case kWalk:
      return s.walks_rays == 0 || launch(kWalk, tiles(s.width_px, 32) * tiles(s.height_px, 8), kPixelThreads, nullptr);
    case kFind:
      return launch(kFind, at_once_[kFind], kPixelThreads, nullptr);
    case kUpdateByOne:
      return by_four_ || launch(kUpdateByOne, kUpdateWaves * at_once_[kUpdateByOne], kUpdateThreads, nullptr);
    case kUpdateByFour:
      return !by_four_ || launch(kUpdateByFour, kUpdateWaves * at_once_[kUpdateByFour], kUpdateThreads, nullptr);
    case kClasses:
      return launch_classes();
    default:
      return launch_export(0);
  }
}

bool CardSession::launch_classes() {
  std::uint32_t room = control_->class_room;
  void* arguments[] = {&classes_, &card_counters_, &room};
  return launch(kClasses, at_once_[kClasses], kParcelThreads, arguments);
}

bool CardSession::launch_export(std::uint32_t first) {
  std::uint32_t room = control_->room;
  void* arguments[] = {&parcels_, &first, &room};
  return launch(kExport, 8 * processors_, kParcelThreads, arguments);
}

/// Everything of the input but the colours.
bool CardSession::copy_depth() {
  const char* input = shared<const char>(control_->input);
  const std::uint64_t bytes = reinterpret_cast<std::uintptr_t>(memory_.rgb) - base_;
  return check(driver_.copy_to_card_async(params_symbol_, input + offsetof(FrameInput, params), sizeof(FrameParams),
                                          stream_),
               "parameters") &&
         check(driver_.copy_to_card_async(base_, input, bytes, stream_), "input");
}

bool CardSession::copy_colour() {
  const std::uint64_t first = reinterpret_cast<std::uintptr_t>(memory_.rgb) - base_;
  return check(driver_.copy_to_card_async(base_ + first, shared<const char>(control_->input) + first,
                                          control_->input_bytes - first, stream_),
               "input");
}

bool CardSession::launch_part(Part part) {
  if (part == Part::until_colours && !copy_depth()) return false;
  if (part != Part::from_colours && !(launch_step(kRead) && launch_step(kWalk) && launch_step(kFind))) return false;
  if (part == Part::until_colours) return true;
  if (part == Part::from_colours && !copy_colour()) return false;
  return launch_step(kUpdateByOne) && launch_step(kUpdateByFour);
}

bool CardSession::run_part(CuHandle graph, Part part) {
  return graph != nullptr ? check(driver_.graph_launch(graph, stream_), "graph") : launch_part(part);
}

/// The program copies colours while the card works already. It takes some tens of microseconds, unless it has died.
bool CardSession::wait_for_colours() {
  const auto is_there = [&] {
    return __atomic_load_n(&control_->coloured, __ATOMIC_ACQUIRE) ==
           __atomic_load_n(&control_->asked, __ATOMIC_ACQUIRE);
  };
  for (int i = 0; i < kColourSpins; ++i) {
    if (is_there()) return true;
  }
  for (int i = 0; i < kColourNaps; ++i) {
    const timespec nap{0, 100'000};
    nanosleep(&nap, nullptr);
    if (is_there()) return true;
  }
  return false;
}

bool CardSession::run_frame() {
  first_parcels_sent_ = false;
  if (!run_part(first_graph_, Part::until_colours) || !wait_for_colours() ||
      !run_part(last_graph_, Part::from_colours) || !launch_classes()) {
    return false;
  }
  if (!mapped_) return check(driver_.stream_synchronize(stream_), "frame") && fetch_classes();
  // Parcels come while the program is busy with classes.
  first_parcels_sent_ = true;
  return check(driver_.event_record(classes_there_, stream_), "event") && launch_export(0) &&
         check(driver_.event_synchronize(classes_there_), "frame");
}

/// Events around the launches of the frame, and around what comes back. While the copies before them are under way
/// everything is handed to the driver, so that the times are the card's alone.
bool CardSession::run_timed() {
  bool ok =
      wait_for_colours() && copy_depth() && copy_colour() && check(driver_.event_record(events_[0], stream_), "event");
  ok = ok && run_part(launch_graph_, Part::launches_alone) &&
       check(driver_.event_record(events_[1], stream_), "event") && launch_classes() &&
       check(driver_.event_record(events_[2], stream_), "event") && launch_export(0) &&
       check(driver_.event_record(events_[3], stream_), "event") && check(driver_.stream_synchronize(stream_), "frame");
  for (int i = 0; ok && i < 3; ++i) {
    float ms = 0.0F;
    ok = check(driver_.event_elapsed_time(&ms, events_[i], events_[i + 1]), "event");
    control_->stage_us[i] = 1000.0F * ms;
  }
  first_parcels_sent_ = mapped_;
  return ok && fetch_classes();
}

bool CardSession::run_stages() {
  bool ok =
      wait_for_colours() && check(driver_.event_record(events_[0], stream_), "event") && copy_depth() && copy_colour();
  for (int i = kRead; ok && i < kKernelCount; ++i) {
    ok = check(driver_.event_record(events_[i], stream_), "event") && launch_step(i);
  }
  ok = ok && check(driver_.event_record(events_[kKernelCount], stream_), "event") &&
       check(driver_.stream_synchronize(stream_), "frame");
  for (int i = 0; ok && i < kKernelCount; ++i) {
    float ms = 0.0F;
    ok = check(driver_.event_elapsed_time(&ms, events_[i], events_[i + 1]), "event");
    control_->stage_us[i] = 1000.0F * ms;
  }
  first_parcels_sent_ = mapped_;
  return ok && fetch_classes();
}

bool CardSession::import_blocks(std::uint32_t count) {
  if (count > control_->room) return false;
  const auto at = [](const auto* p) { return static_cast<CuDevicePointer>(reinterpret_cast<std::uintptr_t>(p)); };
  if (!mapped_) {
    const bool copied =
        check(driver_.copy_to_card(at(parcels_.heads), shared<char>(control_->heads), count * sizeof(ParcelHead)),
              "parcels") &&
        check(driver_.copy_to_card(at(parcels_.planes), shared<char>(control_->planes), count * sizeof(ParcelPlane)),
              "parcels") &&
        check(driver_.copy_to_card(at(parcels_.bricks), shared<char>(control_->bricks),
                                   std::size_t{count} * kBricks * sizeof(ParcelBrick)),
              "parcels");
    if (!copied) return false;
  }
  void* arguments[] = {&parcels_, &count};
  return launch(kImport, 4 * processors_, kParcelThreads, arguments) &&
         check(driver_.stream_synchronize(stream_), "import");
}

bool CardSession::send_blocks(std::uint32_t first) {
  const bool is_sent = first == 0 && first_parcels_sent_;
  return (is_sent || launch_export(first)) && check(driver_.stream_synchronize(stream_), "parcels") &&
         fetch_parcels(first);
}

bool CardSession::fetch(std::uint64_t offset, const void* from, std::uint64_t bytes) {
  return check(driver_.copy_to_host(shared<char>(offset), reinterpret_cast<std::uintptr_t>(from), bytes), "results");
}

bool CardSession::fetch_classes() {
  if (mapped_) return true;
  if (!fetch(offsetof(HelperControl, counters), reinterpret_cast<const void*>(card_counters_), sizeof(FrameCounters))) {
    return false;
  }
  const std::uint64_t count = control_->counters.changed;
  if (count == 0 || count > control_->class_room) return true;
  return fetch(control_->class_heads, classes_.heads, count * sizeof(ClassHead)) &&
         fetch(control_->class_planes, classes_.planes, count * sizeof(ClassPlane));
}

bool CardSession::fetch_parcels(std::uint32_t first) {
  if (mapped_) return true;
  const std::uint32_t changed = control_->counters.changed;
  std::uint64_t count = changed > first ? changed - first : 0;
  if (count > control_->room) count = control_->room;
  if (count == 0) return true;
  return fetch(control_->heads, parcels_.heads, count * sizeof(ParcelHead)) &&
         fetch(control_->planes, parcels_.planes, count * sizeof(ParcelPlane)) &&
         fetch(control_->bricks, parcels_.bricks, count * kBricks * sizeof(ParcelBrick));
}

bool CardSession::obey() {
  switch (static_cast<HelperCommand>(control_->command)) {
    case HelperCommand::import_blocks:
      return import_blocks(control_->count);
    case HelperCommand::run_frame:
      return run_frame();
    case HelperCommand::run_frame_timed:
      return run_timed();
    case HelperCommand::run_stages_timed:
      return run_stages();
    case HelperCommand::send_blocks:
      return send_blocks(control_->count);
    case HelperCommand::set_columns:
      return set_columns();
    case HelperCommand::read_columns:
      return read_columns(control_->count);
    case HelperCommand::spread_grid:
      return spread_grid();
    case HelperCommand::cast_rays:
      return cast_rays(control_->count);
    case HelperCommand::count_looks:
      return count_looks(control_->count);
    case HelperCommand::import_cells:
      return import_cells(control_->first, control_->count);
    case HelperCommand::fit_frame:
      return fit_frame();
    case HelperCommand::add_samples:
      return add_samples();
    case HelperCommand::hang:
    case HelperCommand::end:
      break;
  }
  return false;
}

}  // namespace g3d::mapper::cuda
