// SPDX-License-Identifier: Apache-2.0
// One world with robots and people in it, in lockstep: it stands still between two advance_to calls. Every robot is a
// Kobuki on a ByteLine, a body on the floor and a Kinect on a mast; robots and people see, meet and avoid one another.
// The same options and the same commands at the same times give the same bytes and images, whatever the number of
// threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/base_trouble.hpp"
#include "hal/sim/camera_faults.hpp"
#include "hal/sim/camera_memory.hpp"
#include "hal/sim/floor_contact.hpp"
#include "hal/sim/robot_body.hpp"
#include "hal/sim/sim_kobuki.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "hal/sim/walkers.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

/// The Kinect's intrinsics (525 px at 640 x 480) for an image of another size that shows the same.
[[nodiscard]] CameraModel scaled_kinect(int width_px, int height_px);
/// Camera over the middle of the base, looking ahead. T_base_camera.
[[nodiscard]] Pose forward_camera(double height_m = 0.5);
[[nodiscard]] Pose pose_on_floor(const PlanarPose& T_world_base);

struct SimRobotOptions {
  PlanarPose T_world_base;
  Pose T_base_camera = forward_camera();
  RobotBodyOptions body;
  SimKobukiOptions base;
};

/// Whose odometry a robot gets, drawn by seed.
enum class BaseDrift : std::uint8_t {
  kobuki,  ///< gyro bias of 1 degree per minute (sigma) that wanders, gyro scale 0.5 %, wheel radii 0.3 %, 1 % slip
  /// As pose_drift.hpp has poses drift: 2 % of the way, gyro bias of 0.3 degrees/s (its sign is drawn), and 0.5 degrees
  /// per root second. What of the bias is left is what the driver has not made good at rest.
  rough,
};
/// At `scale` 1 as said above; 0 changes nothing.
void add_drift(SimRobotOptions& robot, double scale, std::uint64_t seed, BaseDrift like = BaseDrift::kobuki);

struct SimBuildingOptions {
  CameraModel camera = scaled_kinect(640, 480);
  bool noise = true;
  std::uint64_t seed = 1;      ///< of the images; each robot's body and base have their own
  int threads = 1;             ///< for each camera
  TimeNs step_ns = 2'000'000;  ///< 1 to 5 ms; divides 20 ms
  std::vector<SimRobotOptions> robots;
  FaultPlan faults;  ///< of each robot's camera, odometry and line; a disk is not in the building
};

/// One touch, from its beginning until 1 cm is between the two again.
struct ContactEvent {
  TimeNs time_ns = 0;
  PlanPoint at;             ///< where
  double speed_mps = 0.0;   ///< of the body, forward or backward
  std::uint8_t bumper = 0;  ///< 0: behind, or above the bumper
  std::int32_t solid = -1;  ///< index in World::primitives; -1: grid wall
  bool moving = false;      ///< a person or another robot
  bool measurable = false;  ///< the camera could have measured it beforehand: see camera_memory.hpp
  bool ran_into = false;    ///< the robot stood still, and who moves came against it
};

struct RobotRecord {
  std::uint64_t contacts = 0;
  std::uint64_t contacts_measurable = 0;
  std::uint64_t contacts_moving = 0;    ///< of all, those with people and robots
  std::uint64_t contacts_robots = 0;    ///< of these, those with robots
  std::uint64_t contacts_ran_into = 0;  ///< of these, those in which this robot stood; they stay in the other counts
  double fastest_contact_mps = 0.0;
  std::uint64_t cliffs = 0;  ///< times that a cliff sensor lost the floor
  std::uint64_t wheel_drops = 0;
  double closest_clearance_m = 0.0;  ///< at most FloorContact::kReach_m less the radius
  double driven_m = 0.0;
  double turned_rad = 0.0;           ///< sum of all turning, either way
  std::vector<ContactEvent> events;  ///< the first kMostEvents
  static constexpr std::size_t kMostEvents = 1024;
};

class SimBuilding {
 public:
  SimBuilding(World world, const SimBuildingOptions& options);

  /// Steps as far as whole steps go. Allocates nothing.
  void advance_to(TimeNs time_ns);
  [[nodiscard]] TimeNs now() const { return now_ns_; }

  [[nodiscard]] std::size_t robot_count() const { return robots_.size(); }
  /// The host's end of a robot's cable.
  [[nodiscard]] ByteLine& line(std::size_t robot) { return robots_[robot]->kobuki; }
  [[nodiscard]] SimKobuki& kobuki(std::size_t robot) { return robots_[robot]->kobuki; }
  [[nodiscard]] const RobotBody& body(std::size_t robot) const { return robots_[robot]->body; }
  [[nodiscard]] PlanarPose T_world_base(std::size_t robot) const { return robots_[robot]->body.T_world_base(); }
  [[nodiscard]] Pose T_world_camera(std::size_t robot) const;
  [[nodiscard]] const RobotRecord& record(std::size_t robot) const { return robots_[robot]->record; }
  /// Somebody carries it there.
  void place(std::size_t robot, const PlanarPose& T_world_base);

  /// All that an image depends on, so that it can be drawn while the building goes on.
  struct Glance {
    TimeNs time_ns = 0;
    Pose T_world_camera;
    std::vector<std::array<float, 2>> places_m;
  };
  /// One frame is taken now. Allocates only if `out` has never been used.
  void glance(std::size_t robot, Glance& out);
  /// Draws it. May run while another thread calls anything but this for the same robot.
  void render(std::size_t robot, const Glance& glance, Frame& out);
  /// What a robot's camera sees now; frames are numbered per robot. `out` has storage for the camera. Allocates
  /// nothing.
  void render(std::size_t robot, Frame& out);
  /// What the planned faults make of a rendered frame, at the building's time; false: the host gets none. One call for
  /// each frame, and not while another thread renders for the same robot.
  [[nodiscard]] bool pass_on(std::size_t robot, Frame& frame, TimeNs time_ns);
  [[nodiscard]] const CameraModel& camera() const { return options_.camera; }

  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] MoverPlaces mover_places_m() const { return places_m_; }
  [[nodiscard]] const FloorContact& floor() const { return floor_; }

 private:
  struct Robot {
    Robot(const FloorContact& floor, const std::shared_ptr<const World>& world, std::int32_t own_mover,
          const SimRobotOptions& robot, const SimRendererOptions& renderer_options);

    SimRobotOptions options;
    std::int32_t mover;
    RobotBody body;
    SimKobuki kobuki;
    SimRenderer renderer;
    CameraMemory memory;
    std::unique_ptr<CameraFaults> spoiled;  ///< only where faults of the camera are planned
    BaseTrouble trouble;
    std::uint64_t next_frame = 0;
    Glance glance;
    bool in_contact = false;
    std::uint8_t cliff_before = 0;
    std::uint8_t drop_before = 0;
    double turned_before_rad = 0.0;
    RobotRecord record;
  };

  void step();
  void spoil(Robot& robot);
  void take_place(const Robot& robot);
  void keep_record(Robot& robot, double speed_before_mps);

  SimBuildingOptions options_;
  std::size_t people_;
  std::shared_ptr<const World> world_;  ///< with a cylinder for every robot
  FloorContact floor_;
  Walkers walkers_;
  std::vector<std::array<float, 2>> places_m_;  ///< of all movers: people, then robots
  std::vector<std::unique_ptr<Robot>> robots_;
  TimeNs now_ns_ = 0;
};

}  // namespace g3d::hal
