// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/real_time_building.hpp"

#include <algorithm>
#include <utility>

#include "hal/sim/pty_kobuki.hpp"

namespace g3d::hal {

Result<std::unique_ptr<RealTimeBuilding>> RealTimeBuilding::start(World world, const SimBuildingOptions& options,
                                                                  Clock& clock, const std::vector<std::string>& links) {
  std::vector<std::unique_ptr<BaseCable>> cables;
  cables.reserve(options.robots.size());
  for (std::size_t i = 0; i < options.robots.size(); ++i) {
    auto pty = PtyKobuki::open(i < links.size() ? links[i] : std::string{});
    if (!pty) return pty.error();
    cables.push_back(std::make_unique<PtyKobuki>(std::move(pty).value()));
  }
  return start(std::move(world), options, clock, std::move(cables));
}

std::unique_ptr<RealTimeBuilding> RealTimeBuilding::start(World world, const SimBuildingOptions& options, Clock& clock,
                                                          std::vector<std::unique_ptr<BaseCable>> cables) {
  return std::unique_ptr<RealTimeBuilding>(new RealTimeBuilding(std::move(world), options, clock, std::move(cables)));
}

RealTimeBuilding::RealTimeBuilding(World world, const SimBuildingOptions& options, Clock& clock,
                                   std::vector<std::unique_ptr<BaseCable>> cables)
    : clock_(clock),
      begin_ns_(clock.now()),
      period_ns_(options.step_ns),
      building_(std::move(world), options),
      cables_(std::move(cables)),
      lines_up_(cables_.size(), true),
      thread_([this] { run(); }) {}

RealTimeBuilding::~RealTimeBuilding() {
  stop_.store(true, std::memory_order_release);
  thread_.join();
}

void RealTimeBuilding::run() {
  for (TimeNs due_ns = begin_ns_; !stop_.load(std::memory_order_acquire); due_ns += period_ns_) {
    clock_.sleep_until(due_ns);
    const TimeNs late_ns = clock_.now() - due_ns;
    if (late_ns > latest_step_ns_.load(std::memory_order_relaxed)) {
      latest_step_ns_.store(late_ns, std::memory_order_relaxed);
    }
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < cables_.size(); ++i) join_line(i);
    for (std::size_t i = 0; i < cables_.size(); ++i) cables_[i]->pump(building_.line(i));
    building_.advance_to(due_ns - begin_ns_);
    for (std::size_t i = 0; i < cables_.size(); ++i) cables_[i]->pump(building_.line(i));
  }
}

// A planned fault that pulls the cable out takes the host's port away as well.
void RealTimeBuilding::join_line(std::size_t robot) {
  const bool is_up = building_.line(robot).state() == LineState::up;
  if (is_up == lines_up_[robot]) return;
  lines_up_[robot] = is_up;
  if (!is_up) {
    cables_[robot]->pull_out();
  } else if (!cables_[robot]->plug_in()) {
    lines_up_[robot] = false;  // no terminal is free: again at the next step
  }
}

std::string RealTimeBuilding::path(std::size_t robot) {
  return with(robot, [](SimBuilding&, const BaseCable& cable) { return cable.path(); });
}

RealTimeBuilding::Camera::Camera(RealTimeBuilding& building, std::size_t robot, double rate_hz)
    : building_(building),
      robot_(robot),
      model_(building.building_.camera()),
      period_ns_(static_cast<TimeNs>(1e9 / rate_hz)) {}

CameraRead RealTimeBuilding::Camera::read(Frame& out) {
  for (;;) {
    if (stopped_.load(std::memory_order_acquire)) return {CameraEvent::end, {}};
    ++next_;
    // Whoever comes too late for a frame gets the next one, as with a real camera.
    const TimeNs now_ns = building_.clock_.now() - building_.begin_ns_;
    next_ = std::max(next_, static_cast<std::uint64_t>(std::max<TimeNs>(now_ns, 0) / period_ns_));
    building_.clock_.sleep_until(building_.begin_ns_ + static_cast<TimeNs>(next_) * period_ns_);
    const bool has_power = building_.with(robot_, [&](SimBuilding& building, const BaseCable&) {
      if (!building.kobuki(robot_).kinect_has_power()) return false;
      building.glance(robot_, glance_);
      return true;
    });
    if (!has_power) continue;
    building_.building_.render(robot_, glance_, out);
    out.stamp_ns += building_.begin_ns_;
    out.sequence = next_;
    if (!building_.building_.pass_on(robot_, out, glance_.time_ns)) continue;
    return {CameraEvent::frame, {}};
  }
}

}  // namespace g3d::hal
