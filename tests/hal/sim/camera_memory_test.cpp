// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/camera_memory.hpp"

#include <catch2/catch.hpp>

#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

namespace {

constexpr TimeNs kSecond = 1'000'000'000;
constexpr HeightSlice kBody{0.02, 0.6};

/// Whether the first solid, touched at (1.9, 0), could be measured from base poses.
bool could(const char* text, const std::vector<PlanarPose>& poses) {
  const World world = parse_world(text, "w").value();
  CameraMemory memory(world, scaled_kinect(160, 120));
  TimeNs t = 0;
  for (const PlanarPose& pose : poses) memory.add(t += kSecond, compose(pose_on_floor(pose), forward_camera()), {});
  FloorContact::Thing thing;
  thing.kind = FloorContact::Kind::solid;
  thing.solid = 0;
  thing.at = {0.178, 1.9, 0.0};
  return memory.could_measure(thing, kBody, t + kSecond);
}

}  // namespace

TEST_CASE("what stood in view between 0.8 and 3.5 m could have been measured") {
  const char* box = "box 2 0 0  0.2 1 1\n";
  CHECK(could(box, {{0, 0, 0}}));
  CHECK_FALSE(could(box, {}));
  CHECK_FALSE(could(box, {{1.2, 0, 0}}));              // too near
  CHECK_FALSE(could(box, {{-2, 0, 0}}));               // too far
  CHECK_FALSE(could(box, {{0, 0, 1.5}}));              // looked elsewhere
  CHECK_FALSE(could(box, {{4, 0, 3.14159265}}));       // saw its other side
  CHECK(could(box, {{0, 0, 1.5}, {0.5, 0.5, -0.3}}));  // one frame is enough
}

TEST_CASE("what was hidden, black, of glass or above and below the image could not") {
  CHECK_FALSE(could("box 2 0 0  0.2 1 1\nbox 1 0 0  0.1 3 2\n", {{0, 0, 0}}));
  CHECK(could("box 2 0 0  0.2 1 1\nbox 1 0 0  0.1 3 2 glass\n", {{0, 0, 0}}));
  CHECK_FALSE(could("box 2 0 0  0.2 1 1 dark\n", {{0, 0, 0}}));
  CHECK_FALSE(could("box 2 0 0  0.2 1 1 glass\n", {{0, 0, 0}}));
  // 4 cm high: the image reaches down to 0.5 - 1.9 * 0.457 m at its distance, but not at 1 m.
  CHECK(could("box 2 0 0  0.2 1 0.04\n", {{0, 0, 0}}));
  CHECK_FALSE(could("box 2 0 0  0.2 1 0.04\n", {{0.95, 0, 0}}));
}

TEST_CASE("what moves counts where it was, and only some time before") {
  World world;
  const std::size_t mover = world.add_moving_cylinder(0, 0.2, 1.7, {});
  CameraMemory memory(world, scaled_kinect(160, 120));
  FloorContact::Thing thing;
  thing.kind = FloorContact::Kind::solid;
  thing.solid = 0;
  thing.mover = static_cast<std::int32_t>(mover);
  const std::array<std::array<float, 2>, 1> ahead = {{{2.0F, 0.0F}}};
  const std::array<std::array<float, 2>, 1> behind = {{{-2.0F, 0.0F}}};
  const Pose eye = forward_camera();
  memory.add(kSecond, eye, behind);
  CHECK_FALSE(memory.could_measure(thing, kBody, 2 * kSecond));
  memory.add(2 * kSecond, eye, ahead);
  CHECK_FALSE(memory.could_measure(thing, kBody, 2 * kSecond + 200'000'000));
  CHECK(memory.could_measure(thing, kBody, 2 * kSecond + 400'000'000));
}

TEST_CASE("a long run thins out what it remembers and still has the first frame") {
  World world;
  world.add_box({2, 0, 0}, {0.2, 1, 1}, 0, {});
  CameraMemory memory(world, scaled_kinect(160, 120));
  memory.add(0, forward_camera(), {});
  const Pose away = look_at({0, 0, 0.5}, {-1, 0, 0.5});
  for (std::size_t i = 0; i < 3 * CameraMemory::kFrames; ++i) memory.add(static_cast<TimeNs>(i), away, {});
  CHECK(memory.frames() <= CameraMemory::kFrames);
  CHECK(memory.frames() > CameraMemory::kFrames / 2);
  FloorContact::Thing thing;
  thing.kind = FloorContact::Kind::solid;
  thing.solid = 0;
  thing.at = {0.178, 1.9, 0.0};
  CHECK(memory.could_measure(thing, kBody, kSecond));
}
