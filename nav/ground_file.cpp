// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_file.hpp"

#include <fmt/format.h>

#include "hal/image/file_bytes.hpp"

namespace g3d::nav {
namespace {

std::uint8_t grey_of(mapper::State state) {
  switch (state) {
    case mapper::State::occupied:
      return kOccupiedGrey;
    case mapper::State::free:
      return kFreeGrey;
    case mapper::State::unknown:
      break;
  }
  return kUnknownGrey;
}

}  // namespace

hal::GreyImage ground_image(const GroundGrid& ground) {
  if (ground.cells.empty()) return {{1, 1}, 255, {kUnknownGrey}};
  hal::GreyImage image{{ground.columns, ground.rows}, 255, {}};
  image.pixels.reserve(ground.cells.size());
  for (int row = ground.rows - 1; row >= 0; --row) {
    for (int column = 0; column < ground.columns; ++column) image.pixels.push_back(grey_of(ground.at(column, row)));
  }
  return image;
}

std::string ground_yaml(const GroundGrid& ground, const std::string& image_name) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {}\norigin: [{:.6f}, {:.6f}, 0.000000]\nnegate: 0\noccupied_thresh: 0.65\n"
      "free_thresh: 0.196\n",
      image_name, ground.resolution_m, ground.origin_x_m, ground.origin_y_m);
}

hal::Result<void> write_ground(const GroundGrid& ground, const std::string& stem) {
  const std::string image_path = stem + ".pgm";
  if (auto done = hal::write_pgm(image_path, ground_image(ground), ""); !done) return done;
  const std::size_t slash = image_path.rfind('/');
  const std::string image_name = slash == std::string::npos ? image_path : image_path.substr(slash + 1);
  return hal::write_file_atomic(stem + ".yaml", ground_yaml(ground, image_name));
}

}  // namespace g3d::nav
