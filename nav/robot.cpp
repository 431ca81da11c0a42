// SPDX-License-Identifier: Apache-2.0
#include "nav/robot.hpp"

namespace g3d::nav {
namespace {

constexpr std::size_t kReadBytes = 1024;  // 20 ms bring some 90

}  // namespace

Robot::Robot(const RobotConfig& config, hal::Clock& clock)
    : config_(config),
      clock_(clock),
      driver_(config.driver),
      mapper_(config.mapper, config.camera, {}),
      navigator_(mapper_.map().grid(), config.navigator),
      senses_({config.camera, config.T_base_camera, config.T_world_start, config.frame_watch}),
      placing_(config.align, config.camera, config.T_base_camera, mapper_.fit_card()),
      body_mask_(config.camera, config.robot_height_m),
      loops_(config.loops ? std::make_unique<mapper::submaps::DrivingLoops>(
                                mapper_.map(), config.camera, *config.loops,
                                [this](const mapper::submaps::ChainMove& move) { placing_.correct(move); })
                          : nullptr) {
  mapper_.follow_columns(navigator_.column_tables());
}

hal::PlanarPose Robot::T_world_base() const {
  return compose(placing_.T_world_odometry(), senses_.in_world(driver_.state().T_world_base));
}

void Robot::on_line(hal::ByteLine& line, hal::TimeNs now) {
  const bool is_lost = line.state() == hal::LineState::lost;
  if (is_lost && !was_lost_) driver_.on_line_lost();
  was_lost_ = is_lost;
  std::array<std::uint8_t, kReadBytes> bytes;
  while (const std::size_t count = line.read(bytes)) driver_.on_bytes({bytes.data(), count}, now);
  std::array<std::uint8_t, hal::kobuki::BaseDriver::kMaxOut_bytes> out;
  if (const std::size_t count = driver_.tick(now, out)) (void)line.write({out.data(), count});

  const hal::kobuki::BaseState& base = driver_.state();
  if (base.packets != packets_seen_) {
    packets_seen_ = base.packets;
    navigator_.on_base(senses_.feel(base, placing_.T_world_odometry()), now);
    if (senses_.feels_battery_low(base)) navigator_.command(MissionEvent::battery_low);
  } else {
    navigator_.on_verdict(base.verdict);
  }
  if (packets_seen_ == 0 || ticks_++ % static_cast<std::uint64_t>(config_.steps_per_command) != 0) return;
  const hal::TimeNs start_ns = clock_.now();
  const hal::Twist wanted = navigator_.step(now);
  navigate_times_.add(clock_.now() - start_ns);
  driver_.set_command(wanted, now);
  if (navigator_.is_rear_free()) driver_.set_rear_free(now);
}

void Robot::on_frame(const hal::Frame& whole, hal::TimeNs now) {
  ++frames_.delivered;
  Sight sight = senses_.look(whole, driver_.poses(), now);
  if (sight.is_alive) driver_.set_camera_alive(whole.stamp_ns);
  if (sight.refused) {
    drop(*sight.refused);
    return;
  }
  if (moves_map(whole.stamp_ns, now)) {
    drop(hal::DropReason::map_moving);
    return;
  }
  const hal::TimeNs align_start_ns = clock_.now();
  // Who drives about is no part of the building.
  const hal::Frame& frame = body_mask_.without_bodies(whole, sight.T_world_camera, team_);
  placing_.place(frame, mapper_.map(), sight);
  align_times_.add(clock_.now() - align_start_ns);
  const hal::PlanarPose& base = sight.T_world_base;
  if (frames_.integrated == 0) {
    mapper_.free_footprint({base.x_m, base.y_m, 0.0}, config_.navigator.explorer.body_radius_m, config_.robot_height_m);
  }
  const hal::TimeNs start_ns = clock_.now();
  const mapper::FrameReport report = mapper_.integrate(frame, sight.T_world_camera);
  integrate_times_.add(clock_.now() - start_ns);
  if (report.status == mapper::FrameStatus::out_of_range) {
    drop(hal::DropReason::out_of_range);
    return;
  }
  if (report.status == mapper::FrameStatus::pool_full) ++pool_full_frames_;
  refused_blocks_ += report.refused_blocks;
  ++frames_.integrated;
  last_frame_pose_ = sight.T_world_camera;
  if (shared_ == nullptr) {
    navigator_.on_map(mapper_.map(), mapper_.changed_slots(), mapper_.card_columns(), now);
  } else {
    navigator_.on_map(shared_->map(), shared_->on_own(mapper_.map(), mapper_.changed_slots()), {}, now);
  }
  navigator_.on_frame(whole, config_.camera, base, now);
  if (loops_ == nullptr) return;
  const hal::TimeNs loops_start_ns = clock_.now();
  loops_->add(frame, placing_.last(), placing_.aligner()->samples(), mapper_.changed_slots());
  loops_times_.add(clock_.now() - loops_start_ns);
}

bool Robot::moves_map(hal::TimeNs stamp_ns, hal::TimeNs now) {
  if (loops_ == nullptr) return false;
  loops_->wait_if_due(stamp_ns);
  const hal::TimeNs start_ns = clock_.now();
  if (loops_->is_moving()) {
    const auto slots = loops_->move_on();
    if (shared_ == nullptr) {
      navigator_.on_map_moving(mapper_.map(), slots);
    } else {
      navigator_.on_map_moving(shared_->map(), shared_->on_own(mapper_.map(), slots));
    }
    if (!loops_->is_moving()) {
      placing_.move(loops_->move());
      navigator_.on_map_moved(loops_->move(), now);
    }
  } else if (loops_->begins_to_move(stamp_ns)) {
    navigator_.on_map_moving(mapper_.map(), {});
  } else {
    return false;
  }
  loops_times_.add(clock_.now() - start_ns);
  return true;
}

}  // namespace g3d::nav
