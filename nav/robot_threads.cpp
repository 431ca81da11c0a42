// SPDX-License-Identifier: Apache-2.0
#include "nav/robot_threads.hpp"

#include <pthread.h>

#include <algorithm>

#include "hal/linux/cpu_time.hpp"

namespace g3d::nav {
namespace {

constexpr std::size_t kPosesWaiting = 4096;  // more than two minutes of frames
constexpr hal::TimeNs kTeamWordEvery_ns = 100'000'000;
// Of a mapper that is given frames: then nobody knows what has come into the way.
constexpr hal::TimeNs kLongestMapping_ns = 1'000'000'000;

std::size_t frames_waiting(const RobotThreadsConfig& config) { return std::max<std::size_t>(config.frames_waiting, 1); }

void name_thread(const char* name) { (void)pthread_setname_np(pthread_self(), name); }

}  // namespace

const char* RobotThreads::name_of(Stage stage) {
  switch (stage) {
    case Stage::read:
      return "read";
    case Stage::look:
      return "look";
    case Stage::align:
      return "align";
    case Stage::integrate:
      return "integrate";
    case Stage::loops:
      return "loops";
    case Stage::end_to_end:
      return "end_to_end";
    case Stage::hand_over:
      return "hand_over";
    case Stage::ground:
      return "ground";
    case Stage::navigate:
      return "navigate";
    case Stage::navigate_late:
      return "navigate_late";
    case Stage::control_jitter:
      return "control_jitter";
    case Stage::count_:
      break;
  }
  return "unknown";
}

RobotThreads::RobotThreads(const RobotThreadsConfig& config, const RobotParts& parts)
    : config_(config),
      parts_(parts),
      base_(parts.line, parts.clock, base_options(), parts.guard, parts.recorder),
      senses_({config.robot.camera, config.robot.T_base_camera, config.robot.T_world_start, config.robot.frame_watch}),
      mapper_(config.robot.mapper, config.robot.camera, {}),
      placing_(config.robot.align, config.robot.camera, config.robot.T_base_camera, mapper_.fit_card()),
      loops_(config.robot.loops ? std::make_unique<mapper::submaps::DrivingLoops>(
                                      mapper_.map(), config.robot.camera, *config.robot.loops,
                                      [this](const mapper::submaps::ChainMove& move) { placing_.correct(move); })
                                : nullptr),
      navigator_(mapper_.map().grid(), config.robot.navigator),
      body_mask_(config.robot.camera, config.robot.robot_height_m),
      // Besides those that wait, the camera fills one and the mapper has one: so there is always one to be filled next.
      pool_(config.robot.camera, frames_waiting(config) + 2),
      to_mapper_(frames_waiting(config)),
      poses_(kPosesWaiting) {
  mapper_.follow_columns(navigator_.column_tables());
}

RobotThreads::~RobotThreads() { stop(); }

hal::kobuki::BaseThreadOptions RobotThreads::base_options() {
  hal::kobuki::BaseThreadOptions options = config_.base;
  options.driver = config_.robot.driver;
  options.on_tick = [this](hal::TimeNs late_ns) { times(Stage::control_jitter).add(late_ns); };
  return options;
}

void RobotThreads::start() {
  if (ending_.load(std::memory_order_relaxed) || camera_thread_.joinable()) return;
  base_.start();
  navigator_thread_ = std::thread([this] { navigator_loop(); });
  mapper_thread_ = std::thread([this] { mapper_loop(); });
  camera_thread_ = std::thread([this] { camera_loop(); });
}

void RobotThreads::stop() {
  ending_.store(true, std::memory_order_release);
  base_.stop();  // with zeros: whatever takes long below, it stands
  if (!camera_thread_.joinable()) return;
  if (parts_.end_camera) parts_.end_camera();
  camera_thread_.join();
  mapper_waits_.stop();
  mapper_thread_.join();  // the navigator still takes its last maps
  navigator_ending_.store(true, std::memory_order_release);
  navigator_thread_.join();
  if (loops_ != nullptr) loops_->finish();
}

void RobotThreads::camera_loop() {
  name_thread("camera");
  std::uint32_t index = 0;
  bool has_frame = pool_.try_acquire(index);
  hal::kobuki::PoseHistory poses;
  while (has_frame && !ending_.load(std::memory_order_acquire)) {
    const hal::TimeNs start_ns = parts_.clock.now();
    const std::int64_t cpu_ns = hal::thread_cpu_ns();
    hal::rest(config_.camera_progress);
    const hal::CameraRead read = parts_.camera.read(pool_[index]);
    hal::tick(config_.camera_progress);
    camera_read_cpu_ns_ += hal::thread_cpu_ns() - cpu_ns;
    if (read.event == hal::CameraEvent::end) break;
    const hal::TimeNs now_ns = parts_.clock.now();
    times(Stage::read).add(now_ns - start_ns);
    delivered_.fetch_add(1, std::memory_order_relaxed);
    if (read.event == hal::CameraEvent::dropped) {
      drop(read.reason);
      continue;
    }
    (void)base_.poses().read(poses);
    const Sight sight = senses_.look(pool_[index], poses, now_ns);
    if (sight.is_alive) base_.set_camera_alive(pool_[index].stamp_ns);
    add_time(Stage::look, now_ns);
    if (sight.refused) {
      drop(*sight.refused);
      continue;
    }
    mapper_given_ns_.store(now_ns, std::memory_order_release);
    const auto oldest = to_mapper_.push_overwrite_oldest({index, sight});
    mapper_waits_.wake();
    if (oldest) {
      drop(hal::DropReason::queue_full);
      index = oldest->frame_index;
    } else {
      has_frame = pool_.try_acquire(index);
    }
  }
  hal::rest(config_.camera_progress);
  camera_cpu_ns_ = hal::thread_cpu_ns() - camera_read_cpu_ns_;
  camera_ended_.store(true, std::memory_order_release);
}

void RobotThreads::mapper_loop() {
  name_thread("mapper");
  JudgedFrame judged;
  while (mapper_waits_.wait([&] { return to_mapper_.try_pop(judged); })) {
    hal::tick(config_.mapper_progress);
    mapper_alive_ns_.store(parts_.clock.now(), std::memory_order_release);
    integrate(judged);
    mapper_alive_ns_.store(parts_.clock.now(), std::memory_order_release);
    pool_.release(judged.frame_index);
    hal::rest(config_.mapper_progress);
  }
  mapper_cpu_ns_ = hal::thread_cpu_ns();
}

void RobotThreads::integrate(JudgedFrame& judged) {
  const hal::Frame& whole = pool_[judged.frame_index];
  if (team_ != nullptr) (void)team_->sight.read_newer(mapped_team_seen_, mapped_team_);
  const hal::Frame& frame = body_mask_.without_bodies(whole, judged.sight.T_world_camera, mapped_team_);
  if (moves_map(frame.stamp_ns)) {
    drop(hal::DropReason::map_moving);
    return;
  }
  const hal::TimeNs align_start_ns = parts_.clock.now();
  placing_.place(frame, mapper_.map(), judged.sight);
  T_world_odometry_.write(placing_.T_world_odometry());
  add_time(Stage::align, align_start_ns);
  hal::MappedNote note{frame.stamp_ns, judged.sight.T_world_camera, {}};
  if (integrated_.load(std::memory_order_relaxed) == 0) {
    const hal::PlanarPose& base = judged.sight.T_world_base;
    const double radius_m = config_.robot.navigator.explorer.body_radius_m;
    mapper_.free_footprint({base.x_m, base.y_m, 0.0}, radius_m, config_.robot.robot_height_m);
    note.footprint = {base.x_m, base.y_m, 0.0, radius_m, config_.robot.robot_height_m};
  }
  const hal::TimeNs start_ns = parts_.clock.now();
  const mapper::FrameReport report = mapper_.integrate(frame, judged.sight.T_world_camera);
  const hal::TimeNs mapped_ns = parts_.clock.now();
  times(Stage::integrate).add(mapped_ns - start_ns);
  if (report.status == mapper::FrameStatus::out_of_range) {
    drop(hal::DropReason::out_of_range);
    return;
  }
  times(Stage::end_to_end).add(mapped_ns - frame.stamp_ns);
  if (report.status == mapper::FrameStatus::pool_full) ++pool_full_frames_;
  refused_blocks_ += report.refused_blocks;
  integrated_.fetch_add(1, std::memory_order_relaxed);
  if (!poses_.try_push({frame.stamp_ns, judged.sight.T_world_camera})) ++lost_poses_;
  if (parts_.on_mapped) parts_.on_mapped(note, &frame == &whole ? nullptr : &frame);

  shown_ = judged;
  showing_ = Showing::frame;
  hand_over();
  add_time(Stage::hand_over, mapped_ns);
  if (loops_ != nullptr) {
    const hal::TimeNs loops_start_ns = parts_.clock.now();
    loops_->add(frame, placing_.last(), placing_.aligner()->samples(), mapper_.changed_slots());
    add_time(Stage::loops, loops_start_ns);
  }
  // Last: what is shared ahead of the submaps is withdrawn when they know it, unless it was noted there before.
  if (note_changed_) note_changed_(mapper_.changed_slots());
}

void RobotThreads::hand_over() {
  navigators_turn_.store(true, std::memory_order_release);
  // The navigator outlives this thread, so the wait ends.
  (void)map_waits_.wait([&] { return !navigators_turn_.load(std::memory_order_acquire); });
}

bool RobotThreads::moves_map(hal::TimeNs stamp_ns) {
  if (loops_ == nullptr) return false;
  const hal::TimeNs start_ns = parts_.clock.now();
  moved_slots_ = {};
  showing_ = Showing::map_moves;
  if (loops_->is_moving()) {
    moved_slots_ = loops_->move_on();
    if (!loops_->is_moving()) {
      placing_.move(loops_->move());
      T_world_odometry_.write(placing_.T_world_odometry());
      showing_ = Showing::map_has_moved;
    }
  } else if (!loops_->begins_to_move(stamp_ns)) {
    return false;
  }
  hand_over();
  add_time(Stage::loops, start_ns);
  return true;
}

bool RobotThreads::mapper_is_stuck() const {
  const hal::TimeNs alive_ns = mapper_alive_ns_.load(std::memory_order_acquire);
  return alive_ns != 0 && mapper_given_ns_.load(std::memory_order_acquire) - alive_ns > kLongestMapping_ns;
}

void RobotThreads::navigator_loop() {
  name_thread("navigator");
  const hal::TimeNs period_ns = config_.robot.steps_per_command * hal::kobuki::kPacketPeriod_ns;
  hal::TimeNs due_ns = parts_.clock.now();
  while (!navigator_ending_.load(std::memory_order_acquire)) {
    const hal::TimeNs now_ns = parts_.clock.now();
    const bool is_blind = mapper_is_stuck();
    // A mapper that hangs while it waits for a frame rests, as far as its own entry tells.
    if (!is_blind) hal::tick(config_.navigator_progress);
    take_base(now_ns);
    take_words(now_ns);
    // Without a command the base stops by itself.
    if (now_ns >= due_ns && !is_blind) {
      if (seen_packets_ > 0 && !ending_.load(std::memory_order_acquire)) {
        times(Stage::navigate_late).add(now_ns - due_ns);
        step(now_ns);
      }
      due_ns = std::max(due_ns + period_ns, now_ns);  // what was missed is not made up for
    }
    take_map(parts_.clock.now());
    if (parts_.clock.now() >= next_coverage_ns_) tell(parts_.clock.now());
    parts_.clock.sleep_until(std::min(due_ns, parts_.clock.now() + config_.poll_ns));
  }
  hal::rest(config_.navigator_progress);
  tell(parts_.clock.now());
  navigator_cpu_ns_ = hal::thread_cpu_ns();
}

void RobotThreads::take_base(hal::TimeNs now) {
  if (!base_.state().read_newer(seen_state_, base_state_)) return;
  if (base_state_.packets == seen_packets_) {
    navigator_.on_verdict(base_state_.verdict);
    return;
  }
  seen_packets_ = base_state_.packets;
  (void)T_world_odometry_.read(astray_);
  navigator_.on_base(senses_.feel(base_state_, astray_), now);
  if (senses_.feels_battery_low(base_state_)) navigator_.command(MissionEvent::battery_low);
}

void RobotThreads::take_words(hal::TimeNs now) {
  while (const auto word = hotline_.take()) {
    if (const auto event = event_of(*word)) navigator_.command(*event);
    if (*word == PersonWord::resume) base_.resume();  // an e-stop that was released waits for it as well
    tell(now);
  }
}

void RobotThreads::talk_to_team(hal::TimeNs now) {
  if (team_->sight.read_newer(team_sight_seen_, team_sight_)) navigator_.on_team(team_sight_, now);
  if (now < next_team_word_ns_) return;
  next_team_word_ns_ = now + kTeamWordEvery_ns;
  team_->word.write(navigator_.team_word(now));
}

void RobotThreads::step(hal::TimeNs now) {
  if (team_ != nullptr) talk_to_team(now);
  const hal::Twist wanted = navigator_.step(now);
  base_.set_command(wanted, now);
  if (navigator_.is_rear_free()) base_.set_rear_free(now);
  add_time(Stage::navigate, now);
}

void RobotThreads::take_map(hal::TimeNs now) {
  if (!navigators_turn_.load(std::memory_order_acquire)) return;
  if (showing_ == Showing::frame) {
    if (shared_ == nullptr) {
      navigator_.on_map(mapper_.map(), mapper_.changed_slots(), mapper_.card_columns(), now);
    } else {
      take_shared_map(now);
    }
    navigator_.on_frame(pool_[shown_.frame_index], config_.robot.camera, shown_.sight.T_world_base, now);
  } else {
    if (shared_ == nullptr) {
      navigator_.on_map_moving(mapper_.map(), moved_slots_);
    } else {
      navigator_.on_map_moving(shared_->map(), shared_->on_own(mapper_.map(), moved_slots_));
    }
    if (showing_ == Showing::map_has_moved) navigator_.on_map_moved(loops_->move(), now);
  }
  navigators_turn_.store(false, std::memory_order_release);
  map_waits_.wake();
  add_time(Stage::ground, now);
}

void RobotThreads::take_shared_map(hal::TimeNs now) {
  const auto own = shared_->on_own(mapper_.map(), mapper_.changed_slots());
  navigator_.on_map(shared_->map(), own, {}, now);
  const auto news = shared_->take_news();
  if (!news.empty()) navigator_.on_map(shared_->map(), news, {}, now);
}

void RobotThreads::tell(hal::TimeNs now) {
  next_coverage_ns_ = now + config_.coverage_period_ns;
  if (parts_.coverage && seen_packets_ > 0) {
    coverage_ = parts_.coverage(navigator_.ground());
    navigator_.report().note_coverage(coverage_, now);
  }
  LiveStatus status =
      status_of(navigator_, base_state_, compose(astray_, senses_.in_world(base_state_.T_world_base)), now);
  status.coverage = coverage_;
  hotline_.publish(status);
}

void RobotThreads::drop(hal::DropReason reason) {
  dropped_[static_cast<std::size_t>(reason)].fetch_add(1, std::memory_order_relaxed);
}

mapper::FrameCounts RobotThreads::frames() const {
  mapper::FrameCounts counts;
  counts.delivered = delivered_.load(std::memory_order_relaxed);
  counts.integrated = integrated_.load(std::memory_order_relaxed);
  for (std::size_t i = 0; i < hal::kDropReasonCount; ++i) {
    counts.dropped[i] = dropped_[i].load(std::memory_order_relaxed);
  }
  return counts;
}

std::vector<ThreadTime> RobotThreads::thread_times() const {
  const auto seconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-9; };
  return {{"base", seconds(base_.cpu_ns())},
          {"camera", seconds(camera_cpu_ns_)},
          {"camera_read", seconds(camera_read_cpu_ns_)},
          {"mapper", seconds(mapper_cpu_ns_)},
          {"mapper_workers", seconds(mapper_.workers_cpu_ns())},
          {"navigator", seconds(navigator_cpu_ns_)}};
}

std::vector<mapper::NamedStage> RobotThreads::stages() const {
  std::vector<mapper::NamedStage> named;
  for (std::size_t i = 0; i < kStages; ++i) named.push_back({name_of(static_cast<Stage>(i)), times_[i]});
  return named;
}

}  // namespace g3d::nav
