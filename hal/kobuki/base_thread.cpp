// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/base_thread.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>

#include "hal/linux/cpu_time.hpp"

namespace g3d::hal::kobuki {

BaseThread::BaseThread(ByteLine& line, Clock& clock, const BaseThreadOptions& options, LineGuard* guard,
                       LineRecorder* recorder)
    : line_(line), clock_(clock), options_(options), guard_(guard), recorder_(recorder), driver_(options.driver) {}

BaseThread::~BaseThread() { stop(); }

void BaseThread::start() {
  if (!thread_.joinable() && !ending_.load(std::memory_order_relaxed)) thread_ = std::thread([this] { run(); });
}

void BaseThread::stop() {
  ending_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void BaseThread::run() {
  (void)pthread_setname_np(pthread_self(), "base");
  const sched_param priority{options_.realtime_priority};
  own_health_.is_realtime =
      options_.realtime_priority > 0 && pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
  own_health_.line_is_up = line_.state() == LineState::up;

  std::array<std::uint8_t, BaseDriver::kMaxOut_bytes> out;
  TimeNs due_ns = 0;
  while (!ending_.load(std::memory_order_acquire)) {
    hal::tick(options_.progress);
    take_wishes();
    const bool heard = read_line();
    const Conditions before = driver_.state().conditions;
    const TimeNs now_ns = clock_.now();
    const std::size_t size = driver_.tick(now_ns, out);
    if (size > 0) send({out.data(), size});
    if (driver_.next_tick_ns() != due_ns) {  // it was a tick
      own_health_.latest_tick_ns = due_ns == 0 ? 0 : now_ns - due_ns;
      if (options_.on_tick && due_ns != 0) options_.on_tick(own_health_.latest_tick_ns);
      due_ns = driver_.next_tick_ns();
      health_.write(own_health_);
    }
    if (heard || size > 0 || !(driver_.state().conditions == before)) state_.write(driver_.state());
    if (heard) poses_.write(driver_.poses());
    tell_devices();
    if (guard_ != nullptr) guard_->beat();
    clock_.sleep_until(std::min(now_ns + options_.poll_ns, due_ns));
  }
  hal::rest(options_.progress);
  say_farewell();
  cpu_ns_ = thread_cpu_ns();
}

void BaseThread::take_wishes() {
  const std::uint32_t e_stops = e_stops_.load(std::memory_order_acquire);
  if (e_stops != seen_e_stops_) driver_.set_e_stop(true);
  seen_e_stops_ = e_stops;
  const StopWord word = ask_devices();
  driver_.set_e_stop(e_stop_pressed_.load(std::memory_order_acquire) || word == StopWord::stop);
  driver_.set_e_stop_awaited(word == StopWord::not_yet);
  const std::uint32_t resumes = resumes_.load(std::memory_order_acquire);
  if (resumes != seen_resumes_) (void)driver_.resume();  // while pressed: in vain, and to be said again
  seen_resumes_ = resumes;

  Wish wish;
  if (command_.read_newer(seen_command_, wish)) driver_.set_command(wish.wanted, wish.stamp_ns);
  const TimeNs image_ns = image_ns_.load(std::memory_order_acquire);
  if (image_ns != kNever_ns) driver_.set_camera_alive(image_ns);
  const TimeNs rear_free_ns = rear_free_ns_.load(std::memory_order_acquire);
  if (rear_free_ns != kNever_ns) driver_.set_rear_free(rear_free_ns);
}

StopWord BaseThread::ask_devices() {
  StopWord strictest = StopWord::go;
  for (SafetyDevice* const device : options_.safety_devices)
    strictest = stricter(strictest, device->look(clock_.now()));
  return strictest;
}

void BaseThread::tell_devices() {
  if (options_.safety_devices.empty()) return;
  const BaseState& state = driver_.state();
  const SafetyNews news{state.verdict.state, state.conditions, state.commanded, state.battery_v};
  for (SafetyDevice* const device : options_.safety_devices) device->show(news, clock_.now());
}

bool BaseThread::read_line() {
  std::array<std::uint8_t, 512> bytes;
  // Bounded: a line that gives without end must not keep the next tick waiting.
  constexpr int kMaxReads = 8;
  bool heard = false;
  for (int i = 0; i < kMaxReads; ++i) {
    const std::size_t count = line_.read(bytes);
    if (count == 0) break;
    heard = true;
    const TimeNs received_ns = clock_.now();
    driver_.on_bytes({bytes.data(), count}, received_ns);
    if (recorder_ != nullptr) recorder_->put({bytes.data(), count}, received_ns);
  }
  const bool is_up = line_.state() == LineState::up;
  if (own_health_.line_is_up && !is_up) {
    ++own_health_.line_losses;
    driver_.on_line_lost();
  }
  own_health_.line_is_up = is_up;
  return heard;
}

void BaseThread::send(std::span<const std::uint8_t> bytes) {
  if (!line_.write(bytes)) ++own_health_.refused_writes;
}

void BaseThread::say_farewell() {
  std::array<std::uint8_t, BaseDriver::kMaxOut_bytes> out;
  const std::size_t size = driver_.farewell(out);
  for (int i = 0; i < options_.farewell_packets; ++i) {
    send({out.data(), size});
    if (guard_ != nullptr) guard_->beat();
    clock_.sleep_until(clock_.now() + options_.farewell_gap_ns);
  }
  for (SafetyDevice* const device : options_.safety_devices) device->say_farewell(clock_.now());
  state_.write(driver_.state());
  health_.write(own_health_);
}

}  // namespace g3d::hal::kobuki
