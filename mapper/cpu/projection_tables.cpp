// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/projection_tables.hpp"

namespace g3d::mapper::cpu {

void fill_projection_tables(const SensorGeometry& sensor, const FrameGeometry& frame, ProjectionTables& tables) {
  const auto& R = frame.rotation;
  const float r = sensor.resolution_m;
  for (std::size_t place = 0; place < kBlockVoxels; ++place) {
    const VoxelIndex v = decode(place);
    const float x = static_cast<float>(v.x) * r;
    const float y = static_cast<float>(v.y) * r;
    const float z = static_cast<float>(v.z) * r;
    tables.x_px_m[place] = sensor.camera.fx_px * (R[0] * x + R[3] * y + R[6] * z);
    tables.y_px_m[place] = sensor.camera.fy_px * (R[1] * x + R[4] * y + R[7] * z);
    tables.z_units[place] = sensor.camera.depth_units_per_metre * (R[2] * x + R[5] * y + R[8] * z);
  }
}

}  // namespace g3d::mapper::cpu
