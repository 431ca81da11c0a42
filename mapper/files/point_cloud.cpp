// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/point_cloud.hpp"

#include <fmt/format.h>

#include "hal/image/file_bytes.hpp"

namespace g3d::mapper {
namespace {

bool is_hidden(const VoxelMap& map, const VoxelIndex& v) {
  const auto occupied = [&](int dx, int dy, int dz) {
    return state_of(map.at(VoxelIndex{v.x + dx, v.y + dy, v.z + dz})) == State::occupied;
  };
  return occupied(-1, 0, 0) && occupied(1, 0, 0) && occupied(0, -1, 0) && occupied(0, 1, 0) && occupied(0, 0, -1) &&
         occupied(0, 0, 1);
}

Bytes with_header(const std::string& header, std::size_t data_bytes) {
  Bytes out;
  out.reserve(header.size() + data_bytes);
  out.insert(out.end(), header.begin(), header.end());
  return out;
}

}  // namespace

std::vector<CloudPoint> occupied_points(const VoxelMap& map, const PointCloudOptions& options) {
  const hal::RigidTransform T = hal::to_transform(options.T_world_map);
  std::vector<CloudPoint> points;
  BlockValues values;
  for (const BlockKey key : map.sorted_keys()) {
    map.read_stored_block(key, values);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (state_of(values[i]) != State::occupied) continue;
      const VoxelIndex v = decode((key << kBlockShift) | i);
      if (options.only_surface && is_hidden(map, v)) continue;
      const auto p = map.grid().centre_m(v);
      std::array<double, 3> world;
      for (std::size_t row = 0; row < 3; ++row) {
        world[row] = static_cast<double>(T.translation_m[row]);
        for (std::size_t column = 0; column < 3; ++column)
          world[row] += static_cast<double>(T.rotation[3 * row + column]) * p[column];
      }
      CloudPoint point{static_cast<float>(world[0]), static_cast<float>(world[1]), static_cast<float>(world[2])};
      if ((values[i] & kHasColourBit) != 0) {
        point.r = static_cast<std::uint8_t>(values[i] >> 24);
        point.g = static_cast<std::uint8_t>(values[i] >> 16);
        point.b = static_cast<std::uint8_t>(values[i] >> 8);
      }
      points.push_back(point);
    }
  }
  return points;
}

Bytes encode_ply(const std::vector<CloudPoint>& points) {
  Bytes out = with_header(fmt::format("ply\nformat binary_little_endian 1.0\ncomment occupied voxel centres, metres\n"
                                      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
                                      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
                                      points.size()),
                          points.size() * 15);
  for (const CloudPoint& p : points) {
    put(out, std::array<float, 3>{p.x_m, p.y_m, p.z_m});
    put(out, std::array<std::uint8_t, 3>{p.r, p.g, p.b});
  }
  return out;
}

Bytes encode_pcd(const std::vector<CloudPoint>& points) {
  Bytes out = with_header(
      fmt::format("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\n"
                  "TYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\n"
                  "DATA binary\n",
                  points.size()),
      points.size() * 16);
  for (const CloudPoint& p : points) {
    put(out, std::array<float, 3>{p.x_m, p.y_m, p.z_m});
    put(out, (std::uint32_t{p.r} << 16) | (std::uint32_t{p.g} << 8) | p.b);  // PCL packs the three into a float's bits
  }
  return out;
}

hal::Result<std::size_t> write_point_cloud(const VoxelMap& map, const std::string& path,
                                           const PointCloudOptions& options) {
  const std::vector<CloudPoint> points = occupied_points(map, options);
  if (const auto done = hal::write_file_atomic(path, path.ends_with(".pcd") ? encode_pcd(points) : encode_ply(points));
      !done) {
    return done.error();
  }
  return points.size();
}

}  // namespace g3d::mapper
