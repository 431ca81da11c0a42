// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/level_codec.hpp"

#include <algorithm>

namespace g3d::mapper {
namespace {

constexpr int kLevels = kMaxLevel + 1;

struct Neighbours {
  std::array<std::uint16_t, 3> place;  ///< of x-1, y-1, z-1, wrapped into the lower block where it lies there
  std::array<bool, 3> in_lower_block;
};

constexpr std::array<Neighbours, kBlockVoxels> make_neighbours() {
  std::array<Neighbours, kBlockVoxels> table{};
  for (int place = 0; place < kBlockVoxels; ++place) {
    const VoxelIndex v = decode(static_cast<MCode>(place));
    const std::array<VoxelIndex, 3> lower{VoxelIndex{(v.x + 7) & 7, v.y, v.z}, VoxelIndex{v.x, (v.y + 7) & 7, v.z},
                                          VoxelIndex{v.x, v.y, (v.z + 7) & 7}};
    const std::array<bool, 3> crosses{v.x == 0, v.y == 0, v.z == 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      table[static_cast<std::size_t>(place)].place[axis] = static_cast<std::uint16_t>(encode(lower[axis]));
      table[static_cast<std::size_t>(place)].in_lower_block[axis] = crosses[axis];
    }
  }
  return table;
}
constexpr std::array<Neighbours, kBlockVoxels> kNeighbours = make_neighbours();

constexpr std::array<std::uint8_t, kLevels> make_classes() {
  std::array<std::uint8_t, kLevels> table{};
  for (int level = 0; level < kLevels; ++level) {
    const int group = level == 0               ? 0
                      : level < kUnknownLevel  ? 1
                      : level == kUnknownLevel ? 2
                      : level < kMaxLevel      ? 3
                                               : 4;
    table[static_cast<std::size_t>(level)] = static_cast<std::uint8_t>(group);
  }
  return table;
}
/// Saturated free, free, unknown, occupied, saturated occupied.
constexpr std::array<std::uint8_t, kLevels> kClassOfLevel = make_classes();
constexpr int kClasses = 5;
static_assert(kLevelStreams == 3 * kClasses);

struct Prediction {
  int level;
  int stream;
};

Prediction predict(int a, int b, int c) {
  const int median = std::max(std::min(a, b), std::min(std::max(a, b), c));  // also the majority, if there is one
  const int disagreeing = static_cast<int>(a != median) + static_cast<int>(b != median) + static_cast<int>(c != median);
  return {median, disagreeing * kClasses + kClassOfLevel[static_cast<std::size_t>(median)]};
}

Prediction predict_place(std::size_t place, const LevelPlane& own, const LowerPlanes& lower) {
  const Neighbours& n = kNeighbours[place];
  return predict((n.in_lower_block[0] ? *lower.x : own)[n.place[0]], (n.in_lower_block[1] ? *lower.y : own)[n.place[1]],
                 (n.in_lower_block[2] ? *lower.z : own)[n.place[2]]);
}

}  // namespace

const LevelPlane& constant_plane(std::uint8_t level) {
  static const auto planes = [] {
    std::array<LevelPlane, kLevels> all;
    for (std::size_t i = 0; i < all.size(); ++i) all[i].fill(static_cast<std::uint8_t>(i));
    return all;
  }();
  return planes[level];
}

void encode_levels(const LevelPlane& levels, const LowerPlanes& lower, LevelStreams& out) {
  for (std::size_t place = 0; place < kBlockVoxels; ++place) {
    const Prediction p = predict_place(place, levels, lower);
    const int residual = levels[place] - p.level;
    out[static_cast<std::size_t>(p.stream)].push_back(
        static_cast<std::uint8_t>(residual < 0 ? residual + kLevels : residual));
  }
}

bool LevelDecoder::decode(const LowerPlanes& lower, LevelPlane& out) {
  for (std::size_t place = 0; place < kBlockVoxels; ++place) {
    const Prediction p = predict_place(place, out, lower);
    const auto stream = static_cast<std::size_t>(p.stream);
    if (places_[stream] >= streams_[stream].size()) return false;
    const int residual = streams_[stream][places_[stream]++];
    if (residual >= kLevels) return false;
    const int level = p.level + residual;
    out[place] = static_cast<std::uint8_t>(level >= kLevels ? level - kLevels : level);
  }
  return true;
}

bool LevelDecoder::at_end() const {
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    if (places_[i] != streams_[i].size()) return false;
  }
  return true;
}

}  // namespace g3d::mapper
