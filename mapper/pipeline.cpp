// SPDX-License-Identifier: Apache-2.0
#include "mapper/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "mapper/align/aligner.hpp"
#include "mapper/rolling_window.hpp"
#include "mapper/submaps/looped_map.hpp"

namespace g3d::mapper {
namespace {

constexpr std::size_t kWriterQueue_frames = 64;
constexpr hal::TimeNs kProgressPeriod_ns = 100'000'000;
constexpr hal::TimeNs kStopPoll_ns = 10'000'000;
// A hole in a log (or a clock that was set) is not waited for in real time.
constexpr double kLongestWait_s = 5.0;

std::size_t frames_under_way(const PipelineConfig& config) {
  return static_cast<std::size_t>(std::clamp(config.frames_under_way, 1, 64));
}

}  // namespace

const char* to_string(Stage stage) {
  switch (stage) {
    case Stage::read:
      return "read";
    case Stage::pose:
      return "pose";
    case Stage::align:
      return "align";
    case Stage::integrate:
      return "integrate";
    case Stage::write:
      return "write";
    case Stage::loops:
      return "loops";
    case Stage::end_to_end:
      return "end_to_end";
    case Stage::count_:
      break;
  }
  return "unknown";
}

Pipeline::Pipeline(hal::DepthCamera& camera, const hal::PoseSource& poses, Mapper& mapper, FrameSink& sink,
                   hal::Clock& clock, const PipelineConfig& config)
    : camera_(camera),
      poses_(poses),
      mapper_(mapper),
      sink_(sink),
      clock_(clock),
      config_(config),
      pool_(camera.model(), frames_under_way(config) + 1),
      read_at_ns_(std::make_unique<hal::TimeNs[]>(pool_.count())),
      to_pose_(pool_.count()),
      to_mapper_(pool_.count()),
      to_writer_(kWriterQueue_frames) {}

void Pipeline::run() {
  std::thread writer([this] { writer_loop(); });
  std::thread mapper([this] { mapper_loop(); });
  std::thread pose([this] { pose_loop(); });
  std::atomic<bool> ended{false};
  std::thread camera([this, &ended] {
    camera_loop();
    ended.store(true, std::memory_order_release);
  });
  hal::TimeNs next_progress_ns = clock_.now() + kProgressPeriod_ns;
  while (!ended.load(std::memory_order_acquire)) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(kStopPoll_ns / 2));
    if (clock_.now() < next_progress_ns) continue;
    sink_.on_progress(progress());
    next_progress_ns = clock_.now() + kProgressPeriod_ns;
  }
  // In this order each thread drains what the one before it left, then ends.
  camera.join();
  pose_parking_.stop();
  pose.join();
  mapper_parking_.stop();
  mapper.join();
  writer_parking_.stop();
  writer.join();
  sink_.on_progress(progress());
}

void Pipeline::camera_loop() {
  std::uint32_t index = 0;
  if (!pool_.try_acquire(index)) return;
  for (;;) {
    if (stop_requested_.load(std::memory_order_relaxed)) {
      interrupted_ = true;
      return;
    }
    const hal::TimeNs start_ns = clock_.now();
    const hal::CameraRead read = camera_.read(pool_[index]);
    if (read.event == hal::CameraEvent::end) return;
    add_time(Stage::read, start_ns);
    delivered_.fetch_add(1, std::memory_order_relaxed);
    if (read.event == hal::CameraEvent::dropped) {
      drop(read.reason);
      continue;
    }
    if (!is_lockstep() && !wait_until_due(pool_[index].stamp_ns)) {
      drop(hal::DropReason::interrupted);
      continue;
    }
    // Real time: this frame goes on only if there is another one to fill next.
    std::uint32_t next = 0;
    if (!is_lockstep() && !pool_.try_acquire(next)) {
      drop(hal::DropReason::queue_full);
      continue;
    }
    read_at_ns_[index] = clock_.now();
    (void)to_pose_.try_push(index);  // has room for every frame of the pool
    pose_parking_.wake();
    if (is_lockstep() && !camera_parking_.wait([&] { return pool_.try_acquire(next); })) return;
    index = next;
  }
}

bool Pipeline::wait_until_due(hal::TimeNs stamp_ns) {
  const hal::TimeNs now_ns = clock_.now();
  const double wait_s =
      !schedule_stamp_ns_
          ? 0.0
          : (static_cast<double>(stamp_ns) - static_cast<double>(*schedule_stamp_ns_)) / config_.rate / 1e9 -
                static_cast<double>(now_ns - schedule_start_ns_) / 1e9;
  if (!schedule_stamp_ns_ || std::abs(wait_s) > kLongestWait_s) {
    schedule_stamp_ns_ = stamp_ns;  // the first frame, or time jumped: count anew from here
    schedule_start_ns_ = now_ns;
    return true;
  }
  const hal::TimeNs due_ns = now_ns + static_cast<hal::TimeNs>(wait_s * 1e9);
  while (clock_.now() < due_ns) {
    if (stop_requested_.load(std::memory_order_relaxed)) return false;
    clock_.sleep_until(std::min(due_ns, clock_.now() + kStopPoll_ns));
  }
  return true;
}

void Pipeline::pose_loop() {
  std::uint32_t index = 0;
  while (pose_parking_.wait([&] { return to_pose_.try_pop(index); })) {
    const hal::TimeNs start_ns = clock_.now();
    PosedMessage message{{index, {}}, {}, false};
    const auto reason = find_pose(pool_[index].stamp_ns, message.posed.T_world_camera);
    message.usable = !reason.has_value();
    if (reason) drop(*reason);
    add_time(Stage::pose, start_ns);
    message.T_odometry_camera = message.posed.T_world_camera;
    if (message.usable && config_.aligner != nullptr && !config_.aligner->has_card()) {
      const hal::TimeNs align_start_ns = clock_.now();
      message.posed.T_world_camera = config_.aligner->align(pool_[index], message.T_odometry_camera).T_world_camera;
      add_time(Stage::align, align_start_ns);
    }
    (void)to_mapper_.try_push(message);  // has room for every frame of the pool
    mapper_parking_.wake();
  }
}

// Only a frame with a pose moves time on: one with a stamp from the far future must not condemn all that follow.
std::optional<hal::DropReason> Pipeline::find_pose(hal::TimeNs stamp_ns, hal::Pose& T_world_camera) {
  if (last_stamp_ns_ && stamp_ns <= *last_stamp_ns_) return hal::DropReason::time_backwards;
  switch (poses_.pose_at(stamp_ns, T_world_camera)) {
    case hal::PoseStatus::not_known:
      return hal::DropReason::no_pose;
    case hal::PoseStatus::invalid:
      return hal::DropReason::bad_pose;
    case hal::PoseStatus::ok:
      break;
  }
  if (!hal::is_valid(T_world_camera)) return hal::DropReason::bad_pose;
  last_stamp_ns_ = stamp_ns;
  return std::nullopt;
}

void Pipeline::mapper_loop() {
  PosedMessage message;
  while (mapper_parking_.wait([&] { return to_mapper_.try_pop(message); })) {
    if (message.usable) integrate(message);
    pool_.release(message.posed.frame_index);
    camera_parking_.wake();
  }
  if (config_.looped != nullptr) (void)config_.looped->finish();
}

void Pipeline::align_here(const hal::Frame& frame, MappedFrame& mapped) {
  const hal::TimeNs start_ns = clock_.now();
  if (config_.looped != nullptr) {
    mapped.T_world_camera = config_.looped->align(frame, mapped.T_odometry_camera).T_world_camera;
  } else if (config_.aligner != nullptr && config_.aligner->has_card()) {
    mapped.T_world_camera = config_.aligner->align(frame, mapped.T_odometry_camera).T_world_camera;
  } else {
    return;
  }
  add_time(Stage::align, start_ns);
}

void Pipeline::integrate(const PosedMessage& message) {
  const hal::Frame& frame = pool_[message.posed.frame_index];
  MappedFrame mapped{frame.stamp_ns, message.posed.T_world_camera, message.T_odometry_camera, {}};
  align_here(frame, mapped);
  if (config_.window != nullptr) config_.window->prepare(mapped.T_world_camera);
  if (config_.looped != nullptr) config_.looped->prepare();
  if (config_.footprint && !std::exchange(footprint_freed_, true)) {
    const hal::Pose T_world_base = hal::compose(mapped.T_world_camera, hal::inverse(config_.footprint->T_base_camera));
    mapper_.free_footprint(T_world_base.translation_m, config_.footprint->radius_m, config_.footprint->height_m);
  }
  const hal::TimeNs integrate_start_ns = clock_.now();
  mapped.report = mapper_.integrate(frame, mapped.T_world_camera);
  if (mapped.report.status == FrameStatus::out_of_range) {
    drop(hal::DropReason::out_of_range);
    return;
  }
  add_time(Stage::integrate, integrate_start_ns);
  add_time(Stage::end_to_end, read_at_ns_[message.posed.frame_index]);
  if (config_.looped != nullptr) {
    const hal::TimeNs loops_start_ns = clock_.now();
    (void)config_.looped->add(frame, mapper_.changed_slots());
    add_time(Stage::loops, loops_start_ns);
  }
  integrated_.fetch_add(1, std::memory_order_relaxed);
  if (mapped.report.status == FrameStatus::pool_full) ++pool_full_frames_;
  refused_blocks_ += mapped.report.refused_blocks;
  // The writer outlives this thread, so the wait always ends.
  if (!to_writer_.try_push(mapped)) {
    (void)writer_room_parking_.wait([&] { return to_writer_.try_push(mapped); });
  }
  writer_parking_.wake();
}

void Pipeline::writer_loop() {
  MappedFrame mapped;
  while (writer_parking_.wait([&] { return to_writer_.try_pop(mapped); })) {
    writer_room_parking_.wake();
    const hal::TimeNs start_ns = clock_.now();
    sink_.on_frame(mapped);
    add_time(Stage::write, start_ns);
  }
}

void Pipeline::drop(hal::DropReason reason) {
  dropped_[static_cast<std::size_t>(reason)].fetch_add(1, std::memory_order_relaxed);
}

void Pipeline::add_time(Stage stage, hal::TimeNs start_ns) {
  times_[static_cast<std::size_t>(stage)].add(clock_.now() - start_ns);
}

FrameCounts Pipeline::frames() const {
  FrameCounts counts;
  counts.delivered = delivered_.load(std::memory_order_relaxed);
  counts.integrated = integrated_.load(std::memory_order_relaxed);
  for (std::size_t i = 0; i < hal::kDropReasonCount; ++i)
    counts.dropped[i] = dropped_[i].load(std::memory_order_relaxed);
  return counts;
}

Progress Pipeline::progress() const {
  const FrameCounts counts = frames();
  return {counts.delivered, counts.integrated, counts.dropped_total()};
}

}  // namespace g3d::mapper
