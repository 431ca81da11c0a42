// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/point_cloud.hpp"

#include <catch2/catch.hpp>
#include <string_view>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

std::string_view text(const Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

std::size_t data_after(const Bytes& bytes, std::string_view last_line) {
  return text(bytes).find(last_line) + last_line.size();
}

/// 4x4x4 occupied voxels, the lowest one red, the others without a colour.
std::unique_ptr<VoxelMap> cube() {
  auto map = std::make_unique<VoxelMap>(Grid{0.1F}, MapCapacity{8, 8, 8});
  BlockValues values;
  values.fill(kUnknownRgbo);
  std::fill_n(values.begin(), 64, Rgbo{32});
  values[0] = make_rgbo(255, 1, 2, 32) | kHasColourBit;
  REQUIRE(map->write_block(block_of({32768, 32768, 32768}), values));
  return map;
}

}  // namespace

TEST_CASE("Points are the centres of the occupied voxels with their colours") {
  const auto points = occupied_points(*cube());
  REQUIRE(points.size() == 64);
  CHECK(points[0].x_m == Approx(0.05));
  CHECK(points[0].y_m == Approx(0.05));
  CHECK(points[0].z_m == Approx(0.05));
  CHECK(static_cast<int>(points[0].r) == 255);
  CHECK(static_cast<int>(points[0].g) == 1);
  CHECK(points[1].x_m == Approx(0.15));
  CHECK(static_cast<int>(points[1].g) == 255);
}

TEST_CASE("Only the surface: the inner voxels are left out") {
  PointCloudOptions options;
  options.only_surface = true;
  CHECK(occupied_points(*cube(), options).size() == 64 - 8);
}

TEST_CASE("Points stand in the world frame") {
  PointCloudOptions options;
  options.T_world_map = hal::from_xyz_rpy(10, 20, 30, 0, 0, 1.5707963267948966);  // x of the map is y of the world
  const auto points = occupied_points(*cube(), options);
  CHECK(points[1].x_m == Approx(10 - 0.05));
  CHECK(points[1].y_m == Approx(20 + 0.15));
  CHECK(points[1].z_m == Approx(30 + 0.05));
}

TEST_CASE("The PLY holds what its header announces") {
  const auto map = tests::random_map(51, 50);
  const auto points = occupied_points(*map);
  REQUIRE(points.size() == map->counts().occupied);
  const Bytes bytes = encode_ply(points);
  CHECK(text(bytes).find("element vertex " + std::to_string(points.size()) + "\n") != std::string_view::npos);
  const std::size_t data = data_after(bytes, "end_header\n");
  REQUIRE(bytes.size() == data + 15 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    float y = 0;
    std::memcpy(&y, bytes.data() + data + 15 * i + 4, 4);
    REQUIRE(y == points[i].y_m);
    REQUIRE(bytes[data + 15 * i + 14] == points[i].b);
  }
}

TEST_CASE("The PCD holds what its header announces") {
  const auto points = occupied_points(*tests::random_map(52, 50));
  const Bytes bytes = encode_pcd(points);
  CHECK(text(bytes).find("POINTS " + std::to_string(points.size()) + "\n") != std::string_view::npos);
  const std::size_t data = data_after(bytes, "DATA binary\n");
  REQUIRE(bytes.size() == data + 16 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::uint32_t rgb = 0;
    std::memcpy(&rgb, bytes.data() + data + 16 * i + 12, 4);
    REQUIRE(rgb == ((std::uint32_t{points[i].r} << 16) | (std::uint32_t{points[i].g} << 8) | points[i].b));
  }
}
