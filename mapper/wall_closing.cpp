// SPDX-License-Identifier: Apache-2.0
#include "mapper/wall_closing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace g3d::mapper {
namespace {

constexpr int kCentres = kCentresSide * kCentresSide * kCentresSide;
// Nine steps of at most a voxel in any direction: less than 16 voxels on an axis.
constexpr int kBoxSide = 20;
constexpr std::array<int, 3> kStrides{1, kCentresSide, kCentresSide* kCentresSide};
constexpr double kBeyondGrid_cells = 40000.0;

struct Small {
  std::array<std::int8_t, 3> v{};
};

/// What is occupied around the centres, one bit a voxel, rows along x.
class Around {
 public:
  /// False: nothing is.
  bool take(const VoxelMap& map, const VoxelIndex& low, const VoxelIndex& high) {
    low_ = low;
    rows_.fill(0);
    bool any = false;
    for (std::int32_t z = low.z & ~7; z <= high.z; z += 8) {
      for (std::int32_t y = low.y & ~7; y <= high.y; y += 8) {
        for (std::int32_t x = low.x & ~7; x <= high.x; x += 8) {
          if (is_inside_grid(VoxelIndex{x, y, z})) any |= take_block(map, {x, y, z}, high);
        }
      }
    }
    return any;
  }
  void find_near() {
    Rows wide{};
    for (int z = 0; z < kBoxSide; ++z) {
      for (int y = 0; y < kBoxSide; ++y) {
        const std::uint32_t row = rows_[at(y, z)];
        const std::uint32_t spread = row | row << 1 | row >> 1;
        for (int to = std::max(0, y - 1); to <= std::min(kBoxSide - 1, y + 1); ++to) wide[at(to, z)] |= spread;
      }
    }
    near_.fill(0);
    for (int z = 0; z < kBoxSide; ++z) {
      for (int to = std::max(0, z - 1); to <= std::min(kBoxSide - 1, z + 1); ++to) {
        for (int y = 0; y < kBoxSide; ++y) near_[at(y, to)] |= wide[at(y, z)];
      }
    }
  }
  [[nodiscard]] bool is_occupied(const Small& p) const { return (rows_[at(p.v[1], p.v[2])] >> p.v[0] & 1U) != 0; }
  /// Itself or one of the 26 around it.
  [[nodiscard]] bool is_near(const Small& p) const { return (near_[at(p.v[1], p.v[2])] >> p.v[0] & 1U) != 0; }
  [[nodiscard]] VoxelIndex voxel(const Small& p) const { return {low_.x + p.v[0], low_.y + p.v[1], low_.z + p.v[2]}; }

 private:
  using Rows = std::array<std::uint32_t, kBoxSide * kBoxSide>;
  [[nodiscard]] static std::size_t at(int y, int z) { return static_cast<std::size_t>(z * kBoxSide + y); }
  bool take_block(const VoxelMap& map, const VoxelIndex& origin, const VoxelIndex& high) {
    const std::uint32_t slot = map.find(block_of(origin));
    if (slot == kNoSlot) return false;
    const BlockHeader& header = map.header(slot);
    const bool is_uniform = header.plane == kNoSlot;
    if (is_uniform && state_of_level(header.uniform_level) != State::occupied) return false;
    const LevelPlane* plane = is_uniform ? nullptr : &map.plane(header.plane);
    if (plane != nullptr) {
      std::uint8_t highest = 0;
      for (const std::uint8_t byte : *plane) highest = std::max<std::uint8_t>(highest, byte & kLevelMask);
      if (highest <= kUnknownLevel) return false;
    }
    bool any = false;
    for (int z = std::max(origin.z, low_.z); z <= std::min(origin.z + 7, high.z); ++z) {
      for (int y = std::max(origin.y, low_.y); y <= std::min(origin.y + 7, high.y); ++y) {
        std::uint32_t& row = rows_[at(y - low_.y, z - low_.z)];
        for (int x = std::max(origin.x, low_.x); x <= std::min(origin.x + 7, high.x); ++x) {
          const std::uint32_t level =
              plane == nullptr ? kMaxLevel : (*plane)[place_at(x & 7, y & 7, z & 7)] & kLevelMask;
          row |= (level > kUnknownLevel ? 1U : 0U) << (x - low_.x);
        }
        any |= row != 0;
      }
    }
    return any;
  }

  VoxelIndex low_;
  Rows rows_;
  Rows near_;
};

/// Between two centres beside each other.
struct Crossing {
  bool is_blocked = false;
  double where = 0.0;  ///< 0 at the first centre, 1 at the second: the middle of what is in the way
  Small voxel;
};

class Closing {
 public:
  Closing(const VoxelMap& map, const Centres& centres) : map_(map), centres_(centres) {}
  void run(BlockValues& values) {
    if (!look_around()) return;
    for (int axis = 0; axis < 3; ++axis) {
      for_each_step(axis, Part::all, [&](int from) { note_step(axis, from); });
    }
    for (int axis = 0; axis < 3; ++axis) {
      for_each_step(axis, Part::of_block, [&](int from) { close_step(axis, from, values); });
    }
  }

 private:
  enum class Part : std::uint8_t { all, of_block };  ///< of the block: from or to a voxel of it
  /// visit(index of the first centre) of every step along an axis.
  template <typename Visit>
  static void for_each_step(int axis, Part part, Visit&& visit) {
    const int low = part == Part::all ? 0 : 1;
    const int high = part == Part::all ? kCentresSide - 1 : kBlockSide_cells;
    const int a = kStrides[static_cast<std::size_t>(axis)];
    const int b = kStrides[static_cast<std::size_t>((axis + 1) % 3)];
    const int c = kStrides[static_cast<std::size_t>((axis + 2) % 3)];
    for (int k = low; k <= high; ++k) {
      for (int j = low; j <= high; ++j) {
        for (int i = 0; i < kCentresSide - 1; ++i) visit(i * a + j * b + k * c);
      }
    }
  }

  bool look_around() {
    std::array<double, 3> low = centres_.front();
    std::array<double, 3> high = low;
    for (const int corner : {9, 90, 99, 900, 909, 990, 999}) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], centres_[static_cast<std::size_t>(corner)][axis]);
        high[axis] = std::max(high[axis], centres_[static_cast<std::size_t>(corner)][axis]);
      }
    }
    std::array<std::int32_t, 3> last{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(low[axis] > -kBeyondGrid_cells && high[axis] < kBeyondGrid_cells)) return false;
      // A rounding may put a centre one voxel off.
      first_[axis] = kAxisOffset_cells + static_cast<std::int32_t>(std::ceil(low[axis] - 1e-3));
      last[axis] = kAxisOffset_cells + static_cast<std::int32_t>(std::ceil(high[axis] + 1e-3));
      if (last[axis] - first_[axis] >= kBoxSide) return false;
    }
    if (!around_.take(map_, {first_[0], first_[1], first_[2]}, {last[0], last[1], last[2]})) return false;
    around_.find_near();
    bool any = false;
    for (int i = 0; i < kCentres; ++i) {
      const auto n = static_cast<std::size_t>(i);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int32_t k = kAxisOffset_cells + static_cast<std::int32_t>(std::ceil(centres_[n][axis]));
        cells_[n].v[axis] = static_cast<std::int8_t>(k - first_[axis]);
      }
      is_occupied_[n] = around_.is_occupied(cells_[n]);
      is_near_[n] = around_.is_near(cells_[n]);
      any |= is_near_[n];
    }
    return any;
  }

  /// The step's voxels between its ends, in their order: at most two, as no axis moves by more than one.
  [[nodiscard]] Crossing cross(std::size_t from, std::size_t to) const {
    Crossing crossing;
    std::array<std::pair<double, int>, 3> faces;
    std::size_t count = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int step = cells_[to].v[axis] - cells_[from].v[axis];
      if (step == 0) continue;
      if (step != 1 && step != -1) return crossing;
      // The face between them: the lower end of the upper voxel.
      const int upper = std::max(cells_[to].v[axis], cells_[from].v[axis]);
      const double face = static_cast<double>(first_[axis] + upper) - (kAxisOffset_cells + 1.0);
      faces[count++] = {(face - centres_[from][axis]) / (centres_[to][axis] - centres_[from][axis]),
                        static_cast<int>(axis)};
    }
    for (const auto& [low, high] : {std::pair{0U, 1U}, {1U, 2U}, {0U, 1U}}) {
      if (high < count && faces[high] < faces[low]) std::swap(faces[low], faces[high]);
    }
    Small at = cells_[from];
    double longest = -1.0;
    for (std::size_t i = 0; i + 1 < count; ++i) {
      const auto axis = static_cast<std::size_t>(faces[i].second);
      at.v[axis] = cells_[to].v[axis];
      if (!around_.is_occupied(at) || faces[i + 1].first - faces[i].first <= longest) continue;
      longest = faces[i + 1].first - faces[i].first;
      crossing = {true, 0.5 * (faces[i].first + faces[i + 1].first), at};
    }
    return crossing;
  }

  void note_step(int axis, int from) {
    const auto a = static_cast<std::size_t>(from);
    const auto b = static_cast<std::size_t>(from + kStrides[static_cast<std::size_t>(axis)]);
    bool& is_blocked = is_blocked_[static_cast<std::size_t>(axis)][a];
    is_blocked = is_occupied_[a] || is_occupied_[b];
    if (!is_blocked && is_near_[a] && is_near_[b]) is_blocked = cross(a, b).is_blocked;
  }

  /// By a voxel beside both.
  [[nodiscard]] bool has_way_round(int axis, int from) const {
    const int to = from + kStrides[static_cast<std::size_t>(axis)];
    for (int other = 0; other < 3; ++other) {
      if (other == axis) continue;
      const int aside = kStrides[static_cast<std::size_t>(other)];
      const auto& across = is_blocked_[static_cast<std::size_t>(other)];
      const auto& along = is_blocked_[static_cast<std::size_t>(axis)];
      const auto n = [](int i) { return static_cast<std::size_t>(i); };
      if (!across[n(from)] && !along[n(from + aside)] && !across[n(to)]) return true;
      if (!across[n(from - aside)] && !along[n(from - aside)] && !across[n(to - aside)]) return true;
    }
    return false;
  }

  void close_step(int axis, int from, BlockValues& values) const {
    const auto a = static_cast<std::size_t>(from);
    const auto b = static_cast<std::size_t>(from + kStrides[static_cast<std::size_t>(axis)]);
    if (!is_blocked_[static_cast<std::size_t>(axis)][a] || is_occupied_[a] || is_occupied_[b]) return;
    if (has_way_round(axis, from)) return;
    const Crossing crossing = cross(a, b);
    const std::size_t closed = crossing.where < 0.5 ? a : b;
    const int place = static_cast<int>(closed);
    const int x = place % kCentresSide - 1;
    const int y = place / kCentresSide % kCentresSide - 1;
    const int z = place / (kCentresSide * kCentresSide) - 1;
    if (((x | y | z) & ~7) != 0) return;  // another block's
    Rgbo& value = values[place_at(x, y, z)];
    const VoxelIndex v = around_.voxel(crossing.voxel);
    const std::uint32_t slot = map_.find(block_of(v));
    const Rgbo wall = stored_value(map_, map_.header(slot), static_cast<int>(encode(v) & kPlaceMask));
    // Of several the surest, then the lowest colour: the order of the steps does not count.
    const bool wins = state_of(value) != State::occupied || level_of(wall) > level_of(value) ||
                      (level_of(wall) == level_of(value) && wall >> 8 < value >> 8);
    if (wins) value = wall;
  }

  const VoxelMap& map_;
  const Centres& centres_;
  Around around_;
  std::array<std::int32_t, 3> first_{};  ///< voxel of the map at the lowest corner
  std::array<Small, kCentres> cells_;
  std::array<bool, kCentres> is_occupied_;
  std::array<bool, kCentres> is_near_;
  std::array<std::array<bool, kCentres>, 3> is_blocked_;  ///< by axis and first centre: what is in the way or an end
};

}  // namespace

void close_walls(const VoxelMap& map, const Centres& centres, BlockValues& values) {
  Closing(map, centres).run(values);
}

}  // namespace g3d::mapper
