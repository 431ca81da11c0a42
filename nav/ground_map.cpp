// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_map.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

using mapper::BlockKey;
using mapper::kBlockSide_cells;
using mapper::VoxelMap;

constexpr std::int32_t kAxis_blocks = mapper::kAxisCells / kBlockSide_cells;
constexpr double kMaxSide_blocks = 4096;

double block_side_m(const mapper::Grid& grid) { return kBlockSide_cells * static_cast<double>(grid.resolution_m); }

int side_in_blocks(const mapper::Grid& grid, double side_m) {
  return static_cast<int>(std::clamp(std::ceil(side_m / block_side_m(grid) - 1e-3), 1.0, kMaxSide_blocks));
}

// Of a square of whole blocks around the start that stays within the 16-bit axes.
std::int32_t first_block(const mapper::Grid& grid, double centre_m, int side_blocks) {
  const double first = std::floor(centre_m / block_side_m(grid) - 0.5 * side_blocks + 0.5) + 0.5 * kAxis_blocks;
  return static_cast<std::int32_t>(std::clamp(first, 0.0, static_cast<double>(kAxis_blocks - side_blocks)));
}

CellGrid<CellState> make_states(const mapper::Grid& grid, int side_blocks, std::int32_t block_x, std::int32_t block_y) {
  const int voxels = voxels_per_ground_cell(grid);
  const int side_cells = side_blocks * kBlockSide_cells / voxels;
  const auto edge_m = [&](std::int32_t block) { return (block - kAxis_blocks / 2) * block_side_m(grid); };
  return {static_cast<double>(grid.resolution_m) * voxels,
          edge_m(block_x),
          edge_m(block_y),
          side_cells,
          side_cells,
          CellState::unknown};
}

}  // namespace

GroundMap::GroundMap(const mapper::Grid& grid, const GroundMapConfig& config)
    : config_(config),
      layers_(ground_layers(grid, config.heights)),
      reader_(layers_, voxels_per_ground_cell(grid), config.speckle_level),
      side_blocks_(side_in_blocks(grid, config.side_m)),
      first_block_x_(first_block(grid, config.centre_x_m, side_blocks_)),
      first_block_y_(first_block(grid, config.centre_y_m, side_blocks_)),
      states_(make_states(grid, side_blocks_, first_block_x_, first_block_y_)),
      evidence_(states_.cells.size()),
      drops_near_(states_.cells.size()),
      floors_near_(states_.cells.size()),
      slot_key_(config.max_slots, VoxelMap::kNoKey),
      stack_noted_(static_cast<std::size_t>(side_blocks_) * static_cast<std::size_t>(side_blocks_)) {
  const int margin = static_cast<int>((config.margin_m + 1e-6) / states_.resolution_m);
  for (int y = -margin; y <= margin; ++y) {
    for (int x = -margin; x <= margin; ++x) {
      if (std::hypot(x, y) * states_.resolution_m <= config.margin_m + 1e-6) margin_offsets_.push_back({x, y});
    }
  }
  stacks_.reserve(stack_noted_.size());
  changed_.reserve(2 * states_.cells.size());
}

void GroundMap::update(const VoxelMap& map, std::span<const std::uint32_t> changed_slots) {
  forget_published_changes();
  for (const std::uint32_t slot : changed_slots) {
    if (slot >= slot_key_.size()) continue;
    const BlockKey key = map.header(slot).key;
    if (slot_key_[slot] != key) note_block(slot_key_[slot]);
    note_block(key);
    slot_key_[slot] = key;
  }
  read_noted_stacks(map);
}

void GroundMap::rebuild(const VoxelMap& map) {
  forget_published_changes();
  std::fill(slot_key_.begin(), slot_key_.end(), VoxelMap::kNoKey);
  const std::size_t slots = std::min<std::size_t>(map.slot_end(), slot_key_.size());
  for (std::uint32_t slot = 0; slot < slots; ++slot) slot_key_[slot] = map.header(slot).key;
  stacks_.clear();
  for (std::uint32_t stack = 0; stack < stack_noted_.size(); ++stack) stacks_.push_back(stack);
  read_noted_stacks(map);
}

void GroundMap::forget_published_changes() {
  changed_.erase(changed_.begin(), changed_.begin() + static_cast<std::ptrdiff_t>(published_));
  published_ = 0;
}

void GroundMap::note_block(BlockKey key) {
  if (key == VoxelMap::kNoKey) return;
  const mapper::VoxelIndex block = mapper::decode(key);
  if (block.z < reader_.first_block_z() || block.z > reader_.last_block_z()) return;
  const std::int32_t column = block.x - first_block_x_;
  const std::int32_t row = block.y - first_block_y_;
  if (column < 0 || row < 0 || column >= side_blocks_ || row >= side_blocks_) return;
  const auto stack = static_cast<std::uint32_t>(row * side_blocks_ + column);
  if (stack_noted_[stack] != 0) return;
  stack_noted_[stack] = 1;
  stacks_.push_back(stack);
}

void GroundMap::read_noted_stacks(const VoxelMap& map) {
  // The order in which a frame's blocks are reported depends on threads; what comes out of here must not.
  std::sort(stacks_.begin(), stacks_.end());
  for (const std::uint32_t stack : stacks_) {
    stack_noted_[stack] = 0;
    read_stack(map, stack);
  }
  stacks_.clear();
  published_ = changed_.size();
}

void GroundMap::read_stack(const VoxelMap& map, std::uint32_t stack) {
  const int column = static_cast<int>(stack) % side_blocks_;
  const int row = static_cast<int>(stack) / side_blocks_;
  ColumnReader::Cells found;
  reader_.read(map, first_block_x_ + column, first_block_y_ + row, found);
  const int side = reader_.cells_per_block();
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      set_evidence({column * side + x, row * side + y}, found[static_cast<std::size_t>(y * side + x)]);
    }
  }
}

void GroundMap::set_evidence(Cell c, Evidence from_voxels) {
  Evidence& evidence = evidence_[states_.index(c)];
  const Evidence before = evidence & kFromVoxels;
  if (from_voxels == before) return;
  evidence = static_cast<Evidence>((evidence & ~kFromVoxels) | from_voxels);
  const Evidence flipped = from_voxels ^ before;
  if ((flipped & kDropSeen) != 0) spread(c, drops_near_, (from_voxels & kDropSeen) != 0 ? 1 : -1);
  if ((flipped & kFloorSeen) != 0) spread(c, floors_near_, (from_voxels & kFloorSeen) != 0 ? 1 : -1);
  if ((flipped & kHitOnce) != 0) refresh_around(c);
  refresh(c);
}

void GroundMap::spread(Cell c, std::vector<std::uint16_t>& counts, int step) {
  for (const Cell& offset : margin_offsets_) {
    const Cell near{c.x + offset.x, c.y + offset.y};
    if (!states_.contains(near)) continue;
    const std::size_t index = states_.index(near);
    const std::uint16_t before = counts[index];
    counts[index] = static_cast<std::uint16_t>(before + step);
    if ((before == 0 || counts[index] == 0) && (evidence_[index] & kAirSeen) != 0) refresh(near);
  }
}

// A single hit counts only beside others, so its judgement depends on its neighbours.
void GroundMap::refresh_around(Cell c) {
  for (int y = c.y - 1; y <= c.y + 1; ++y) {
    for (int x = c.x - 1; x <= c.x + 1; ++x) {
      if (has({x, y}, kHitOnce)) refresh({x, y});
    }
  }
}

void GroundMap::refresh(Cell c) {
  CellState& state = states_.at(c);
  const CellState now = judge(c);
  if (now == state) return;
  state = now;
  // Only endless marking without any update() comes here with a full list.
  if (changed_.size() < changed_.capacity()) changed_.push_back(static_cast<std::uint32_t>(states_.index(c)));
}

CellState GroundMap::judge(Cell c) const {
  const std::size_t index = states_.index(c);
  const Evidence evidence = evidence_[index];
  const bool floor_seen = (evidence & kFloorSeen) != 0;
  if ((evidence & kObstacle) != 0) return CellState::occupied;
  if ((evidence & kHitOnce) != 0 && has_hit_neighbour(c)) return CellState::occupied;
  if ((evidence & kContact) != 0 && (!floor_seen || (evidence & kDistrusted) != 0)) return CellState::occupied;
  if (floor_seen || (evidence & kStart) != 0) return CellState::free;
  if ((evidence & kDropSeen) != 0) return CellState::occupied;
  if ((evidence & kAirSeen) == 0) return CellState::unknown;
  if (drops_near_[index] > 0) return CellState::occupied;
  return (evidence & kLowSeen) != 0 && floors_near_[index] == 0 ? CellState::unknown : CellState::free;
}

bool GroundMap::has_hit_neighbour(Cell c) const {
  for (int y = c.y - 1; y <= c.y + 1; ++y) {
    for (int x = c.x - 1; x <= c.x + 1; ++x) {
      if (!(Cell{x, y} == c) && has({x, y}, kHitOnce)) return true;
    }
  }
  return false;
}

template <typename Visit>
void GroundMap::for_disc(double x_m, double y_m, double radius_m, Visit visit) {
  const Cell low = states_.cell_of(x_m - radius_m, y_m - radius_m);
  const Cell high = states_.cell_of(x_m + radius_m, y_m + radius_m);
  for (int y = std::max(low.y, 0); y <= std::min(high.y, states_.rows - 1); ++y) {
    for (int x = std::max(low.x, 0); x <= std::min(high.x, states_.columns - 1); ++x) {
      const Cell c{x, y};
      if (std::hypot(states_.centre_x_m(c) - x_m, states_.centre_y_m(c) - y_m) <= radius_m) visit(c);
    }
  }
}

void GroundMap::mark_free_disc(double x_m, double y_m, double radius_m) {
  for_disc(x_m, y_m, radius_m, [&](Cell c) {
    evidence_[states_.index(c)] |= kStart;
    refresh(c);
  });
}

void GroundMap::mark_contact(double x_m, double y_m, double radius_m) {
  for_disc(x_m, y_m, radius_m, [&](Cell c) {
    Evidence& evidence = evidence_[states_.index(c)];
    evidence = static_cast<Evidence>(evidence | kContact | ((evidence & kFloorSeen) != 0 ? kDistrusted : 0));
    refresh(c);
  });
}

void GroundMap::forget_contacts() {
  for (std::size_t i = 0; i < evidence_.size(); ++i) {
    if ((evidence_[i] & kContact) == 0) continue;
    evidence_[i] &= static_cast<Evidence>(~(kContact | kDistrusted));
    refresh(states_.cell(i));
  }
}

}  // namespace g3d::nav
