// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/helper_process.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace g3d::mapper::cuda {
namespace {

constexpr int kSpins = 20'000;               // some tens of microseconds: what a frame takes
constexpr hal::TimeNs kLook_ns = 2'000'000;  // how often a waiting thread looks whether the helper still lives
constexpr hal::TimeNs kImportPatience_ns = 1'000'000'000;
constexpr hal::TimeNs kQuestionPatience = 10;  // times a frame's: somebody may ask for more than a frame has pixels
constexpr int kFirstSpareFile = 64;            // the helper's file 3 is the shared memory, whatever is open here

std::uint32_t read_word(const std::uint32_t& word) { return __atomic_load_n(&word, __ATOMIC_ACQUIRE); }

void wake(std::uint32_t& word) { syscall(SYS_futex, &word, FUTEX_WAKE, 1, nullptr, nullptr, 0); }

void sleep_while(std::uint32_t& word, std::uint32_t value, hal::TimeNs most_ns) {
  const timespec limit{most_ns / 1'000'000'000, most_ns % 1'000'000'000};
  syscall(SYS_futex, &word, FUTEX_WAIT, value, &limit, nullptr, 0);
}

/// The helper may have left out the zero at the end.
template <std::size_t kRoom>
std::string text_of(const char (&room)[kRoom]) {
  return {room, strnlen(room, kRoom)};
}

std::string failure(const char* what) { return std::string(what) + ": " + std::strerror(errno); }

bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = write(file, bytes.data(), bytes.size());
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

std::unique_ptr<HelperProcess> HelperProcess::start(const HelperSetup& setup, std::string& problem) {
  if (setup.program.empty() || setup.kernels.empty()) {
    problem = "this build carries no kernels: it was made without clang";
    return nullptr;
  }
  std::unique_ptr<HelperProcess> helper(new HelperProcess);
  HelperControl layout{};
  layout.sizes = setup.sizes;
  layout.room = setup.room;
  layout.class_room = setup.class_room;
  layout.update_warps = setup.update_warps;
  layout.wanted_processors = setup.processors;
  helper->bytes_ = lay_out(layout, setup.kernels.size());
  helper->memory_file_ = memfd_create("g3dmap-card", MFD_CLOEXEC);
  if (helper->memory_file_ < 0 || ftruncate(helper->memory_file_, static_cast<off_t>(helper->bytes_)) != 0) {
    problem = failure("shared memory for the helper");
    return nullptr;
  }
  void* const place = mmap(nullptr, helper->bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, helper->memory_file_, 0);
  if (place == MAP_FAILED) {
    problem = failure("shared memory for the helper");
    return nullptr;
  }
  helper->control_ = static_cast<HelperControl*>(place);
  *helper->control_ = layout;
  helper->fill(setup);
  if (!helper->spawn(setup.program, problem)) return nullptr;
  return helper;
}

void HelperProcess::fill(const HelperSetup& setup) {
  control_->version = kProtocolVersion;
  room_ = setup.room;
  class_room_ = setup.class_room;
  ray_room_ = setup.sizes.rays;
  look_room_ = setup.sizes.looks;
  grid_room_ = setup.sizes.grid_cells;
  column_room_ = setup.sizes.columns;
  surface_slots_ = setup.sizes.surface_slots;
  patience_ns_ = setup.patience_ns;
  std::memcpy(at<char>(control_->program), setup.kernels.data(), setup.kernels.size());
  Memory zero_based{};
  place(zero_based, setup.sizes, 0);
  const auto offset = [](const auto* p) { return reinterpret_cast<std::uintptr_t>(p); };
  depth_ = at<std::uint16_t>(control_->input + offset(zero_based.depth));
  rgb_ = at<std::uint8_t>(control_->input + offset(zero_based.rgb));
  const std::uintptr_t first = offset(zero_based.column_slope);
  std::copy(setup.column_slope.begin(), setup.column_slope.end(), at<float>(control_->sensor));
  std::copy(setup.row_slope.begin(), setup.row_slope.end(),
            at<float>(control_->sensor + offset(zero_based.row_slope) - first));
  std::copy(setup.mask.begin(), setup.mask.end(),
            at<std::uint16_t>(control_->sensor + offset(zero_based.mask) - first));
  parcels_ = {at<ParcelHead>(control_->heads), at<ParcelPlane>(control_->planes), at<ParcelBrick>(control_->bricks)};
  classes_ = {at<ClassHead>(control_->class_heads), at<ClassPlane>(control_->class_planes)};
  grid_question_ = {at<GridSpread>(control_->spread), at<std::uint8_t>(control_->grid_costs),
                    at<std::uint32_t>(control_->grid_distances)};
  columns_ = {at<std::uint64_t>(control_->column_keys), at<std::uint8_t>(control_->column_cells)};
  alignment_ = {at<AlignQuestion>(control_->align_question), at<AlignState>(control_->align_state),
                at<align::SurfaceCell>(control_->align_cells),
                touched_room(tiles_of(setup.sizes.width_px, setup.sizes.height_px), surface_slots_)};
  queries_ = {at<BulkRay>(control_->rays), at<BulkHit>(control_->ray_hits), at<Look>(control_->looks)};
}

bool HelperProcess::spawn(std::span<const std::byte> program, std::string& problem) {
  const int low_file = memfd_create("g3dmap-helper", MFD_CLOEXEC);
  const int file = low_file < 0 ? -1 : fcntl(low_file, F_DUPFD_CLOEXEC, kFirstSpareFile);
  const int memory = fcntl(memory_file_, F_DUPFD_CLOEXEC, kFirstSpareFile);
  int line[2] = {-1, -1};
  const bool joined = socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, line) == 0;
  const int far_end = joined ? fcntl(line[1], F_DUPFD_CLOEXEC, kFirstSpareFile) : -1;
  const bool written = file >= 0 && memory >= 0 && far_end >= 0 && write_all(file, program);
  // vfork: a process with a large map would take milliseconds to copy its page tables, on the mapper thread.
  if (written) pid_ = vfork();
  if (written && pid_ == 0) {
    // Between fork and exec only what is safe there. Ctrl-C is meant for the program, which then ends the helper.
    setpgid(0, 0);
    if (dup2(memory, kHelperFile) == kHelperFile && dup2(far_end, kHelperLine) == kHelperLine) {
      syscall(SYS_close_range, kHelperLine + 1, file - 1, 0);
      syscall(SYS_close_range, file + 1, ~0U, 0);
      char name[] = "g3dmap-helper";
      char* arguments[] = {name, nullptr};
      syscall(SYS_execveat, file, "", arguments, environ, AT_EMPTY_PATH);
    }
    _exit(127);
  }
  if (!written || pid_ < 0) problem = failure("starting the helper");
  line_ = line[0];
  for (const int open : {low_file, file, memory, line[1], far_end}) {
    if (open >= 0) close(open);
  }
  return written && pid_ > 0;
}

HelperProcess::~HelperProcess() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);  // not yet waited for, so the number is still its own
    // A process that hangs in the driver may take its time; it is not waited for any longer.
    for (int i = 0; i < 20 && waits_for_end_ && waitpid(pid_, nullptr, WNOHANG) == 0; ++i) {
      clock_.sleep_until(clock_.now() + 1'000'000);
    }
  }
  if (line_ >= 0) close(line_);
  if (control_ != nullptr) munmap(control_, bytes_);
  if (memory_file_ >= 0) close(memory_file_);
}

bool HelperProcess::has_ended() {
  pollfd line{line_, 0, 0};
  const bool closed = poll(&line, 1, 0) > 0 && (line.revents & (POLLHUP | POLLERR)) != 0;
  if (!ended_ && pid_ > 0 && closed) ended_ = true;
  return ended_;
}

HelperState HelperProcess::state() {
  const auto told = static_cast<HelperState>(read_word(control_->state));
  if (told == HelperState::ready && !has_ended()) return HelperState::ready;
  if (told != HelperState::failed && !has_ended()) return HelperState::starting;
  return HelperState::failed;
}

HelperState HelperProcess::wait_started(hal::TimeNs limit_ns) {
  const hal::TimeNs end_ns = clock_.now() + limit_ns;
  while (state() == HelperState::starting && clock_.now() < end_ns) {
    sleep_while(control_->state, static_cast<std::uint32_t>(HelperState::starting), kLook_ns);
  }
  return state();
}

std::string HelperProcess::problem() const {
  if (std::string text = text_of(control_->problem); !text.empty()) return text;
  return ended_ ? "the helper process ended" : "the helper process does not answer";
}

std::string HelperProcess::note() const { return text_of(control_->note); }

bool HelperProcess::post(HelperCommand command, std::uint32_t count) {
  if (ended_) return false;
  control_->command = static_cast<std::uint32_t>(command);
  control_->count = count;
  ++asked_;
  __atomic_store_n(&control_->asked, asked_, __ATOMIC_RELEASE);
  wake(control_->asked);
  return true;
}

bool HelperProcess::wait_answer(hal::TimeNs patience_ns) {
  for (int i = 0; i < kSpins; ++i) {
    if (read_word(control_->answered) == asked_) return control_->ok == 1;
  }
  const hal::TimeNs end_ns = clock_.now() + patience_ns;
  while (read_word(control_->answered) != asked_) {
    if (has_ended() || clock_.now() > end_ns) return false;
    sleep_while(control_->answered, asked_ - 1, kLook_ns);
  }
  return control_->ok == 1;
}

bool HelperProcess::ask(HelperCommand command, std::uint32_t count, hal::TimeNs patience_ns) {
  return post(command, count) && wait_answer(patience_ns);
}

bool HelperProcess::end(hal::TimeNs patience_ns) {
  const hal::TimeNs end_ns = clock_.now() + patience_ns;
  if (!ask(HelperCommand::end, 0, patience_ns)) return false;
  while (!has_ended() && clock_.now() < end_ns) clock_.sleep_until(clock_.now() + kLook_ns);
  return has_ended();
}

bool HelperProcess::import_blocks(std::uint32_t count) {
  return ask(HelperCommand::import_blocks, count, std::max(kImportPatience_ns, patience_ns_));
}

bool HelperProcess::begin_frame() { return post(frame_command_, 0); }

bool HelperProcess::finish_frame(FrameCounters& counters) {
  __atomic_store_n(&control_->coloured, asked_, __ATOMIC_RELEASE);
  if (!wait_answer(patience_ns_)) return false;
  counters = control_->counters;
  return true;
}

bool HelperProcess::send_blocks(std::uint32_t first) { return ask(HelperCommand::send_blocks, first, patience_ns_); }

bool HelperProcess::set_columns(const ColumnTables& tables) {
  control_->column_tables = tables;
  return ask(HelperCommand::set_columns, 0, patience_ns_);  // within a frame, like what follows
}

bool HelperProcess::read_columns(std::uint32_t first) { return ask(HelperCommand::read_columns, first, patience_ns_); }

bool HelperProcess::spread_grid() { return ask(HelperCommand::spread_grid, 0, kQuestionPatience * patience_ns_); }

bool HelperProcess::import_cells(std::uint32_t first, std::uint32_t count) {
  control_->first = first;
  return ask(HelperCommand::import_cells, count, std::max(kImportPatience_ns, patience_ns_));
}

bool HelperProcess::begin_fit() { return post(HelperCommand::fit_frame, 0); }

bool HelperProcess::finish_fit() {
  __atomic_store_n(&control_->coloured, asked_, __ATOMIC_RELEASE);
  return wait_answer(patience_ns_);
}

bool HelperProcess::add_samples() { return ask(HelperCommand::add_samples, 0, patience_ns_); }

bool HelperProcess::cast_rays(std::uint32_t count, float resolution_m) {
  control_->look_model.resolution_m = resolution_m;
  return ask(HelperCommand::cast_rays, count, kQuestionPatience * patience_ns_) && control_->refused_imports == 0;
}

bool HelperProcess::count_looks(std::uint32_t count, const LookModel& model) {
  control_->look_model = model;
  return ask(HelperCommand::count_looks, count, kQuestionPatience * patience_ns_) && control_->refused_imports == 0;
}

}  // namespace g3d::mapper::cuda
