// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/scene.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper {
namespace {

constexpr int kSeenThrough_cells = 3;      ///< thin unknown seams before a surface are forgiven
constexpr double kOutermost = 0.002;
constexpr double kCeilingCut = 0.72;       ///< of the height, for maps without free space
constexpr double kLowestRoom_m = 1.6;      ///< lower maps have no ceiling

/// Looks up states around a place without a hash walk for every voxel.
class Neighbourhood {
 public:
  explicit Neighbourhood(const VoxelMap& map) : map_(map) {}
  [[nodiscard]] State at(const VoxelIndex& v) {
    if (!is_inside_grid(v)) return State::unknown;
    const MCode code = encode(v);
    const BlockKey key = code >> kBlockShift;
    Entry& entry = entries_[key % entries_.size()];
    if (entry.key != key) {
      entry.key = key;
      entry.slot = map_.find(key);
    }
    if (entry.slot == kNoSlot) return State::unknown;
    const BlockHeader& header = map_.header(entry.slot);
    if (header.plane == kNoSlot) return state_of_level(header.uniform_level);
    return state_of_level(map_.plane(header.plane)[code & kPlaceMask] & kLevelMask);
  }

 private:
  struct Entry {
    BlockKey key = VoxelMap::kNoKey;
    std::uint32_t slot = kNoSlot;
  };
  const VoxelMap& map_;
  std::array<Entry, 1024> entries_;
};

VoxelIndex moved(const VoxelIndex& v, const std::array<int, 3>& by, int times = 1) {
  return {v.x + by[0] * times, v.y + by[1] * times, v.z + by[2] * times};
}

std::uint8_t seen_faces(Neighbourhood& around, const VoxelIndex& v, bool has_free_space) {
  unsigned faces = 0;
  for (std::size_t i = 0; i < kFaceNormals.size(); ++i) {
    State state = around.at(moved(v, kFaceNormals[i]));
    if (!has_free_space) {
      faces |= (state != State::occupied ? 1U : 0U) << i;
      continue;
    }
    for (int step = 2; step <= kSeenThrough_cells && state == State::unknown; ++step) state = around.at(moved(v, kFaceNormals[i], step));
    faces |= (state == State::free ? 1U : 0U) << i;
  }
  return static_cast<std::uint8_t>(faces);
}

std::uint8_t openness(Neighbourhood& around, const VoxelIndex& v) {
  int open = 0;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) open += around.at({v.x + dx, v.y + dy, v.z + dz}) != State::occupied ? 1 : 0;
    }
  }
  return static_cast<std::uint8_t>(open);
}

void measure(Scene& scene, const Grid& grid) {
  if (scene.voxels.empty()) return;
  std::vector<std::int32_t> ks(scene.voxels.size());
  const auto outermost = static_cast<std::ptrdiff_t>(kOutermost * static_cast<double>(ks.size() - 1));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::transform(scene.voxels.begin(), scene.voxels.end(), ks.begin(),
                   [axis](const SceneVoxel& v) { return axis == 0 ? v.index.x : axis == 1 ? v.index.y : v.index.z; });
    std::nth_element(ks.begin(), ks.begin() + outermost, ks.end());
    scene.low_m[axis] = grid.centre_m(ks[static_cast<std::size_t>(outermost)]);
    std::nth_element(ks.begin(), ks.end() - 1 - outermost, ks.end());
    scene.high_m[axis] = grid.centre_m(*(ks.end() - 1 - outermost));
  }
  const double height_m = scene.high_m[2] - scene.low_m[2];
  scene.ceiling_m = height_m < kLowestRoom_m ? scene.high_m[2] + 1.0 : scene.low_m[2] + kCeilingCut * height_m;
}

}  // namespace

Rgb height_colour(double part) {
  constexpr std::array<Rgb, 5> kStops{{{0.20F, 0.30F, 0.65F}, {0.15F, 0.60F, 0.65F}, {0.40F, 0.70F, 0.35F}, {0.92F, 0.78F, 0.30F}, {0.80F, 0.28F, 0.22F}}};
  const double at = std::clamp(part, 0.0, 1.0) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  return mix(kStops[i], kStops[i + 1], static_cast<float>(at - static_cast<double>(i)));
}

Scene make_scene(const VoxelMap& map, bool use_colour) {
  Scene scene;
  Neighbourhood around(map);
  const MapCounts counts = map.counts();
  const bool has_free_space = counts.free > counts.occupied / 4;
  const bool coloured = use_colour && counts.coloured > 0;
  BlockValues values;
  for (const BlockKey key : map.sorted_keys()) {
    map.read_stored_block(key, values);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (state_of(values[i]) != State::occupied) continue;
      SceneVoxel voxel;
      voxel.index = decode((key << kBlockShift) | i);
      voxel.faces = seen_faces(around, voxel.index, has_free_space);
      if (voxel.faces == 0) continue;
      voxel.openness = openness(around, voxel.index);
      const auto channel = [&](int shift) { return static_cast<float>((values[i] >> shift) & 0xFFU) / 255.0F; };
      voxel.colour = (values[i] & kHasColourBit) != 0 ? Rgb{channel(24), channel(16), channel(8)} : Rgb{0.62F, 0.62F, 0.64F};
      scene.voxels.push_back(voxel);
    }
  }
  measure(scene, map.grid());
  if (has_free_space) scene.ceiling_m = 1e9;
  if (coloured) return scene;
  const double height_m = std::max(0.1, scene.high_m[2] - scene.low_m[2]);
  for (SceneVoxel& voxel : scene.voxels) {
    voxel.colour = height_colour((map.grid().centre_m(voxel.index.z) - scene.low_m[2]) / height_m);
  }
  return scene;
}

}  // namespace g3d::mapper
