// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sim_building.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "hal/sim/plain_trig.hpp"
#include "hal/sim/pose_drift.hpp"

namespace g3d::hal {
namespace {

constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;
constexpr double kReleased_m = 0.01;
constexpr double kStands_mps = 0.002;  // slower is no driving: what an acceleration leaves of one step

std::shared_ptr<const World> with_robots(World world, const std::vector<SimRobotOptions>& robots) {
  Material shell;
  shell.colour = {70, 74, 82};
  shell.second_colour = {120, 126, 134};
  shell.texture = Texture::stripes;
  shell.texture_size_m = 0.11F;
  for (const SimRobotOptions& robot : robots) {
    (void)world.add_moving_cylinder(0.0, robot.body.radius_m, robot.body.height_m, shell);
  }
  return std::make_shared<const World>(std::move(world));
}

void add_rough_drift(SimRobotOptions& robot, double scale, std::uint64_t seed) {
  const PoseDrift poses = robot_drift(seed, scale);
  SeededRandom random(SeededRandom(seed).bits());
  const auto either_way = [&](double x) { return random.uniform() < 0.5 ? -x : x; };
  robot.base.gyro_bias_radps += either_way(poses.heading_bias_rad_per_s);
  // Samples are independent: over a second their sum walks by sigma / sqrt(rate).
  robot.base.gyro_noise_radps += poses.heading_walk_rad_per_root_s * std::sqrt(kGyroRate_hz);
  const double wheels = 1.0 + either_way(poses.translation_scale - 1.0);
  robot.base.left_scale *= wheels;
  robot.base.right_scale *= wheels;
  robot.base.seed = random.bits() >> 8;
}

}  // namespace

CameraModel scaled_kinect(int width_px, int height_px) {
  CameraModel camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = 525.0F * static_cast<float>(width_px) / 640.0F;
  camera.fy_px = 525.0F * static_cast<float>(height_px) / 480.0F;
  camera.cx_px = static_cast<float>(width_px - 1) / 2.0F;
  camera.cy_px = static_cast<float>(height_px - 1) / 2.0F;
  return camera;
}

Pose forward_camera(double height_m) { return look_at({0.0, 0.0, height_m}, {1.0, 0.0, height_m}); }

Pose pose_on_floor(const PlanarPose& T_world_base) {
  const SinCos half = sin_cos_deg(T_world_base.heading_rad * kDegreesPerRad / 2.0);
  return {{T_world_base.x_m, T_world_base.y_m, 0.0}, {0.0, 0.0, half.sin, half.cos}};
}

void add_drift(SimRobotOptions& robot, double scale, std::uint64_t seed, BaseDrift like) {
  if (like == BaseDrift::rough) {
    if (scale > 0.0) add_rough_drift(robot, scale, seed);
    return;
  }
  constexpr double kDegPerMinute_radps = std::numbers::pi / 180.0 / 60.0;
  SeededRandom random(seed);
  robot.base.gyro_bias_radps += scale * kDegPerMinute_radps * random.gaussian();
  robot.base.gyro_drift_radps_per_sqrt_s += scale * 1e-5;
  robot.base.gyro_noise_radps += scale * 1e-3;
  robot.base.gyro_scale *= 1.0 + scale * 0.005 * random.gaussian();
  robot.base.left_scale *= 1.0 + scale * 0.003 * random.gaussian();
  robot.base.right_scale *= 1.0 + scale * 0.003 * random.gaussian();
  robot.base.seed = random.bits() >> 8;
  robot.body.slip += scale * 0.01;
  robot.body.seed = random.bits() >> 8;
}

SimBuilding::Robot::Robot(const FloorContact& floor, const std::shared_ptr<const World>& world, std::int32_t own_mover,
                          const SimRobotOptions& robot, const SimRendererOptions& renderer_options)
    : options(robot),
      mover(own_mover),
      body(floor, robot.T_world_base, own_mover, robot.body),
      kobuki(robot.base),
      renderer(world, renderer_options),
      memory(*world, renderer_options.camera) {
  record.closest_clearance_m = FloorContact::kReach_m - robot.body.radius_m;
  record.events.reserve(RobotRecord::kMostEvents);
  glance.places_m.reserve(world->movers().size());
}

SimBuilding::SimBuilding(World world, const SimBuildingOptions& options)
    : options_(options),
      people_(world.movers().size()),
      world_(with_robots(std::move(world), options.robots)),
      floor_(*world_),
      walkers_(*world_, people_),
      places_m_(world_->movers().size()) {
  assert(options.step_ns >= 1'000'000 && options.step_ns <= 5'000'000 &&
         kobuki::kPacketPeriod_ns % options.step_ns == 0);
  for (std::size_t i = 0; i < people_; ++i) places_m_[i] = walkers_.place_m(i);
  for (std::size_t i = 0; i < options.robots.size(); ++i) {
    SimRendererOptions renderer;
    renderer.camera = options.camera;
    renderer.noise = options.noise;
    renderer.seed = options.seed * 1000 + i;
    renderer.threads = options.threads;
    robots_.push_back(
        std::make_unique<Robot>(floor_, world_, static_cast<std::int32_t>(people_ + i), options.robots[i], renderer));
    Robot& robot = *robots_.back();
    robot.trouble = base_trouble_at({}, 0, robot.options.base);
    if (has_fault_of(options.faults, FaultPart::camera)) {
      robot.spoiled = std::make_unique<CameraFaults>(options.camera, renderer.seed);
    }
    take_place(robot);
  }
  for (const auto& robot : robots_) {
    robot->body.place(robot->options.T_world_base, places_m_);
    robot->kobuki.sense(robot->body);
    robot->kobuki.advance_to(0);
  }
}

void SimBuilding::advance_to(TimeNs time_ns) {
  while (now_ns_ + options_.step_ns <= time_ns) step();
}

void SimBuilding::step() {
  const double dt_s = static_cast<double>(options_.step_ns) / 1e9;
  const std::span<const std::array<float, 2>> all(places_m_);
  const double radius_m = robots_.empty() ? 0.0 : robots_.front()->options.body.radius_m;
  walkers_.step(dt_s, all.subspan(people_), radius_m);
  for (std::size_t i = 0; i < people_; ++i) places_m_[i] = walkers_.place_m(i);
  now_ns_ += options_.step_ns;
  for (const auto& robot : robots_) {
    const kobuki::BaseControl drive = robot->kobuki.drive();
    const double speed_before_mps = std::abs(robot->body.velocity().forward_mps);
    robot->body.command(drive.speed_mmps, drive.radius_mm);
    robot->body.step(dt_s, places_m_);
    take_place(*robot);
    keep_record(*robot, speed_before_mps);
    if (!options_.faults.empty()) spoil(*robot);
    robot->kobuki.sense(robot->body);
    robot->kobuki.advance_to(now_ns_);
  }
}

// Only what changes is told, so that others may set faults as well.
void SimBuilding::spoil(Robot& robot) {
  const BaseTrouble trouble = base_trouble_at(options_.faults, now_ns_, robot.options.base);
  if (trouble == robot.trouble) return;
  robot.trouble = trouble;
  robot.kobuki.set_faults(trouble.faults);
  robot.kobuki.set_noise(trouble.to_host, trouble.to_base);
}

bool SimBuilding::pass_on(std::size_t robot, Frame& frame, TimeNs time_ns) {
  CameraFaults* const spoiled = robots_[robot]->spoiled.get();
  if (spoiled == nullptr) return true;
  spoiled->set(fault_at(options_.faults, FaultPart::camera, time_ns).kind);
  return spoiled->apply(frame);
}

void SimBuilding::take_place(const Robot& robot) {
  const PlanarPose& at = robot.body.T_world_base();
  places_m_[static_cast<std::size_t>(robot.mover)] = {static_cast<float>(at.x_m), static_cast<float>(at.y_m)};
}

void SimBuilding::place(std::size_t robot, const PlanarPose& T_world_base) {
  robots_[robot]->body.place(T_world_base, places_m_);
  take_place(*robots_[robot]);
}

void SimBuilding::keep_record(Robot& robot, double speed_before_mps) {
  RobotRecord& record = robot.record;
  const BodySense& sense = robot.body.sense();
  record.driven_m = robot.body.driven_m();
  record.turned_rad += std::abs(robot.body.turned_rad() - robot.turned_before_rad);
  robot.turned_before_rad = robot.body.turned_rad();
  record.closest_clearance_m = std::min(record.closest_clearance_m, sense.clearance_m);
  if (sense.cliff != 0 && robot.cliff_before == 0) ++record.cliffs;
  if (sense.wheel_drop != 0 && robot.drop_before == 0) ++record.wheel_drops;
  robot.cliff_before = sense.cliff;
  robot.drop_before = sense.wheel_drop;

  if (robot.in_contact) {
    robot.in_contact = sense.clearance_m < kReleased_m;
    return;
  }
  if (!sense.touching) return;
  robot.in_contact = true;
  ContactEvent event;
  event.time_ns = now_ns_;
  event.at = sense.touched.at;
  event.speed_mps = speed_before_mps;
  event.bumper = sense.bumper;
  event.solid = sense.touched.solid;
  event.moving = sense.touched.mover >= 0;
  event.measurable = robot.memory.could_measure(sense.touched, {kClimb_m, robot.options.body.height_m}, now_ns_);
  event.ran_into = event.moving && speed_before_mps < kStands_mps;
  ++record.contacts;
  record.contacts_measurable += event.measurable ? 1 : 0;
  record.contacts_moving += event.moving ? 1 : 0;
  record.contacts_robots += sense.touched.mover >= static_cast<std::int32_t>(people_) ? 1 : 0;
  record.contacts_ran_into += event.ran_into ? 1 : 0;
  record.fastest_contact_mps = std::max(record.fastest_contact_mps, event.speed_mps);
  if (record.events.size() < RobotRecord::kMostEvents) record.events.push_back(event);
}

Pose SimBuilding::T_world_camera(std::size_t robot) const {
  return compose(pose_on_floor(T_world_base(robot)), robots_[robot]->options.T_base_camera);
}

void SimBuilding::glance(std::size_t robot, Glance& out) {
  out.time_ns = now_ns_;
  out.T_world_camera = T_world_camera(robot);
  out.places_m.assign(places_m_.begin(), places_m_.end());
  robots_[robot]->memory.add(now_ns_, out.T_world_camera, places_m_);
}

void SimBuilding::render(std::size_t robot, const Glance& glance, Frame& out) {
  Robot& r = *robots_[robot];
  r.renderer.render(glance.T_world_camera, glance.time_ns, r.next_frame++, glance.places_m, r.mover, out);
}

void SimBuilding::render(std::size_t robot, Frame& out) {
  glance(robot, robots_[robot]->glance);
  render(robot, robots_[robot]->glance, out);
}

}  // namespace g3d::hal
