// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/scene.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace g3d::mapper {
namespace {

constexpr double kCoarse_m = 0.05;  ///< what was seen is judged on cells about so large: finer ones show noise
constexpr int kReach_cells = 3;     ///< noise in front of a surface, or a seam that nothing measured
constexpr double kOutermost = 0.002;
constexpr double kCeilingCut = 0.9;        ///< of the height: noise leaves crumbs of the ceiling in the air
constexpr double kBlindCeilingCut = 0.72;  ///< for maps without free space, whose ceiling is drawn whole
constexpr std::uint8_t kAlone = 24;        ///< openness from which on a voxel is noise: at most two neighbours
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

/// How often two voxels' sides go into kCoarse_m, as a power of two (0..3: within a block).
int coarse_levels(const Grid& grid) {
  int levels = 0;
  for (double side_m = static_cast<double>(grid.resolution_m); side_m * 1.6 < kCoarse_m && levels < 3; side_m *= 2)
    ++levels;
  return levels;
}

/// The map `levels` further up its octree: occupied where a few voxels are, free where most are, else unknown.
std::unique_ptr<VoxelMap> make_coarse(const VoxelMap& map, const std::vector<BlockKey>& keys, int levels) {
  const auto voxels_per_cell = std::uint32_t{1} << (3 * levels);
  const auto blocks = static_cast<std::uint32_t>(keys.size() + 1);
  auto coarse = std::make_unique<VoxelMap>(Grid{map.grid().resolution_m * static_cast<float>(1 << levels)},
                                           MapCapacity{blocks, blocks, 1});
  BlockValues fine;
  BlockValues cells;
  cells.fill(kUnknownRgbo);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    map.read_block(keys[i], fine);
    const std::size_t part = static_cast<std::size_t>(keys[i]) & (voxels_per_cell - 1);  // of the coarse block
    const std::size_t cells_per_block = kBlockVoxels / voxels_per_cell;
    for (std::size_t cell = 0; cell < cells_per_block; ++cell) {
      std::uint32_t occupied = 0;
      std::uint32_t free = 0;
      for (std::size_t v = cell * voxels_per_cell; v < (cell + 1) * voxels_per_cell; ++v) {
        occupied += state_of(fine[v]) == State::occupied ? 1 : 0;
        free += state_of(fine[v]) == State::free ? 1 : 0;
      }
      Rgbo& out = cells[part * cells_per_block + cell];
      out = occupied > voxels_per_cell / 32 ? kMaxLevel : free > voxels_per_cell / 2 ? 0 : kUnknownRgbo;
    }
    const bool last_of_block = i + 1 == keys.size() || keys[i + 1] >> (3 * levels) != keys[i] >> (3 * levels);
    if (!last_of_block) continue;
    (void)coarse->write_block(keys[i] >> (3 * levels), cells);
    cells.fill(kUnknownRgbo);
  }
  return coarse;
}

/// The directions from which a coarse cell was seen: free space begins close before it.
std::uint8_t seen_faces(Neighbourhood& coarse, const VoxelIndex& cell) {
  unsigned faces = 0;
  for (std::size_t face = 0; face < kFaceNormals.size(); ++face) {
    for (int step = 1; step <= kReach_cells; ++step) {
      if (coarse.at(moved(cell, kFaceNormals[face], step)) != State::free) continue;
      faces |= 1U << face;
      break;
    }
  }
  return static_cast<std::uint8_t>(faces);
}

std::uint8_t bare_faces(Neighbourhood& around, const VoxelIndex& v) {
  unsigned faces = 0;
  for (std::size_t face = 0; face < kFaceNormals.size(); ++face) {
    faces |= (around.at(moved(v, kFaceNormals[face])) != State::occupied ? 1U : 0U) << face;
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

void measure(Scene& scene, const Grid& grid, double ceiling_cut) {
  if (scene.voxels.empty()) return;
  std::vector<std::int32_t> ks(scene.voxels.size());
  const auto outermost = static_cast<std::ptrdiff_t>(kOutermost * static_cast<double>(ks.size() - 1));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::transform(scene.voxels.begin(), scene.voxels.end(), ks.begin(), [axis](const SceneVoxel& v) {
      return axis == 0 ? v.index.x : axis == 1 ? v.index.y : v.index.z;
    });
    std::nth_element(ks.begin(), ks.begin() + outermost, ks.end());
    scene.low_m[axis] = grid.centre_m(ks[static_cast<std::size_t>(outermost)]);
    std::nth_element(ks.begin(), ks.end() - 1 - outermost, ks.end());
    scene.high_m[axis] = grid.centre_m(*(ks.end() - 1 - outermost));
  }
  const double height_m = scene.high_m[2] - scene.low_m[2];
  scene.ceiling_m = height_m < kLowestRoom_m ? scene.high_m[2] + 1.0 : scene.low_m[2] + ceiling_cut * height_m;
}

}  // namespace

Rgb height_colour(double part) {
  constexpr std::array<Rgb, 5> kStops{{{0.20F, 0.30F, 0.65F},
                                       {0.15F, 0.60F, 0.65F},
                                       {0.40F, 0.70F, 0.35F},
                                       {0.92F, 0.78F, 0.30F},
                                       {0.80F, 0.28F, 0.22F}}};
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
  const std::vector<BlockKey> keys = map.sorted_keys();
  const int levels = has_free_space ? coarse_levels(map.grid()) : 0;
  const std::unique_ptr<VoxelMap> coarse_map = levels > 0 ? make_coarse(map, keys, levels) : nullptr;
  Neighbourhood coarse(coarse_map ? *coarse_map : map);
  BlockValues values;
  for (const BlockKey key : map.sorted_keys()) {
    map.read_stored_block(key, values);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (state_of(values[i]) != State::occupied) continue;
      SceneVoxel voxel;
      voxel.index = decode((key << kBlockShift) | i);
      voxel.bare = bare_faces(around, voxel.index);
      if (voxel.bare == 0) continue;
      const VoxelIndex& v = voxel.index;
      voxel.seen_from = has_free_space ? seen_faces(coarse, {v.x >> levels, v.y >> levels, v.z >> levels}) : voxel.bare;
      if (voxel.seen_from == 0) continue;
      voxel.openness = openness(around, voxel.index);
      if (voxel.openness >= kAlone) continue;
      const auto channel = [&](int shift) { return static_cast<float>((values[i] >> shift) & 0xFFU) / 255.0F; };
      voxel.colour =
          (values[i] & kHasColourBit) != 0 ? Rgb{channel(24), channel(16), channel(8)} : Rgb{0.62F, 0.62F, 0.64F};
      scene.voxels.push_back(voxel);
    }
  }
  measure(scene, map.grid(), has_free_space ? kCeilingCut : kBlindCeilingCut);
  if (coloured) return scene;
  const double height_m = std::max(0.1, scene.high_m[2] - scene.low_m[2]);
  for (SceneVoxel& voxel : scene.voxels) {
    voxel.colour = height_colour((map.grid().centre_m(voxel.index.z) - scene.low_m[2]) / height_m);
  }
  return scene;
}

}  // namespace g3d::mapper
