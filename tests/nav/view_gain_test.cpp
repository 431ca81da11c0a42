// SPDX-License-Identifier: Apache-2.0
#include "nav/view_gain.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d::nav;

namespace {

using Ground = CellGrid<CellState>;

double total(const PanoramaGain& gain) {
  double sum = 0;
  for (const RayGain& ray : gain) sum += static_cast<double>(ray.cells);
  return sum;
}

Ground disc_of_free(double radius_m) {
  Ground ground(0.05, 0.0, 0.0, 201, 201, CellState::unknown);
  for (std::size_t i = 0; i < ground.cells.size(); ++i) {
    const Cell c = ground.cell(i);
    if (std::hypot(c.x - 100, c.y - 100) * 0.05 <= radius_m) ground.cells[i] = CellState::free;
  }
  return ground;
}

}  // namespace

TEST_CASE("without fading hope, a place shows the area of the ring that is unknown") {
  ViewModel model;
  model.hope_m = 1e9;
  const ViewGain camera(model, 0.05);
  PanoramaGain gain;
  camera.look(disc_of_free(2.0), {100, 100}, gain);
  const double ring_cells = 3.14159265 * (3.5 * 3.5 - 2.0 * 2.0) / (0.05 * 0.05);
  CHECK(total(gain) == Approx(ring_cells).epsilon(0.03));
}

TEST_CASE("what lies deeper in the unknown counts less") {
  ViewModel model;
  model.hope_m = 0.5;
  const ViewGain camera(model, 0.05);
  PanoramaGain gain;
  camera.look(disc_of_free(2.0), {100, 100}, gain);
  const double ring_cells = 3.14159265 * (3.5 * 3.5 - 2.0 * 2.0) / (0.05 * 0.05);
  CHECK(total(gain) < 0.5 * ring_cells);
  CHECK(total(gain) > 0.1 * ring_cells);
}

TEST_CASE("rays end at what is occupied, and show nothing if that is too near to be measured") {
  const ViewGain camera(ViewModel{}, 0.05);
  PanoramaGain gain;
  Ground ground(0.05, 0.0, 0.0, 201, 201, CellState::free);
  for (int y = 0; y < 201; ++y) ground.at({150, y}) = CellState::unknown;
  // To the east the strip of unknown cells is 2.5 m away.
  camera.look(ground, {100, 100}, gain);
  CHECK(gain[0].cells > 0.0F);
  CHECK(ground.cell(gain[0].entry).x == 149);
  CHECK(gain[kViewRays / 2].entry == RayGain::kNothing);
  for (int y = 0; y < 201; ++y) ground.at({130, y}) = CellState::occupied;
  camera.look(ground, {100, 100}, gain);
  CHECK(total(gain) == 0.0);

  // Unknown cells before a wall at 0.5 m: the wall gives no reading, so neither do they.
  ground = Ground(0.05, 0.0, 0.0, 201, 201, CellState::free);
  for (int y = 0; y < 201; ++y) ground.at({108, y}) = CellState::unknown;
  for (int y = 0; y < 201; ++y) ground.at({110, y}) = CellState::occupied;
  camera.look(ground, {100, 100}, gain);
  CHECK(gain[0].entry == RayGain::kNothing);
  camera.look(ground, {80, 100}, gain);
  CHECK(ground.cell(gain[0].entry).x == 107);
}

TEST_CASE("the grid's rim ends rays, and the window is a little less than the camera's view") {
  const ViewGain camera(ViewModel{}, 0.05);
  PanoramaGain gain;
  const Ground ground(0.05, 0.0, 0.0, 20, 20, CellState::free);
  camera.look(ground, {0, 0}, gain);
  CHECK(total(gain) == 0.0);
  CHECK(camera.window() * kBearing_rad <= 0.995);
  CHECK(camera.window() * kBearing_rad > 0.9);
}

TEST_CASE("a camera in front of the place sees farther, and measures what is too near to it even less") {
  ViewModel model;
  model.forward_m = 0.3;
  const ViewGain ahead(model, 0.05);
  const ViewGain centred(ViewModel{}, 0.05);
  Ground ground(0.05, 0.0, 0.0, 201, 201, CellState::free);
  for (int y = 0; y < 201; ++y) ground.at({174, y}) = CellState::unknown;  // 3.7 m to the east
  PanoramaGain gain;
  centred.look(ground, {100, 100}, gain);
  CHECK(gain[0].entry == RayGain::kNothing);
  ahead.look(ground, {100, 100}, gain);
  CHECK(gain[0].entry != RayGain::kNothing);

  ground = Ground(0.05, 0.0, 0.0, 201, 201, CellState::free);
  for (int y = 0; y < 201; ++y) ground.at({118, y}) = CellState::unknown;
  for (int y = 0; y < 201; ++y) ground.at({120, y}) = CellState::occupied;  // 1 m to the east
  centred.look(ground, {100, 100}, gain);
  CHECK(gain[0].entry != RayGain::kNothing);
  ahead.look(ground, {100, 100}, gain);
  CHECK(gain[0].entry == RayGain::kNothing);
}
