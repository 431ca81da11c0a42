// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_map.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace g3d::nav {
namespace {

using mapper::BlockKey;
using mapper::kBlockSide_cells;
using mapper::VoxelMap;

constexpr std::int32_t kAxis_blocks = mapper::kAxisCells / kBlockSide_cells;
constexpr double kMaxSide_blocks = 4096;
constexpr std::size_t kTouched_bytes = std::size_t{64} << 20;  // provided before the first frame

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
  constexpr std::int32_t kMiddle_block = kAxis_blocks / 2;
  const auto edge_m = [&](std::int32_t block) { return (block - kMiddle_block) * block_side_m(grid); };
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
      block_layers_(reader_.last_block_z() - reader_.first_block_z() + 1),
      block_evidence_(states_.cells.size() * static_cast<std::size_t>(block_layers_)),
      evidence_(states_.cells.size()),
      drops_near_(states_.cells.size()),
      floors_near_(states_.cells.size()),
      slot_key_(config.max_slots, VoxelMap::kNoKey) {
  const int margin = static_cast<int>((config.margin_m + 1e-6) / states_.resolution_m);
  for (int y = -margin; y <= margin; ++y) {
    for (int x = -margin; x <= margin; ++x) {
      if (std::hypot(x, y) * states_.resolution_m <= config.margin_m + 1e-6) margin_offsets_.push_back({x, y});
    }
  }
  places_.reserve(config.max_slots);
  block_evidence_.touch(kTouched_bytes);
  changed_.reserve(2 * states_.cells.size());
}

void GroundMap::update(const VoxelMap& map, std::span<const std::uint32_t> changed_slots) {
  forget_published_changes();
  for (const std::uint32_t slot : changed_slots) {
    const BlockKey key = map.header(slot).key;
    const bool is_followed = slot < slot_key_.size();
    note_block(key == VoxelMap::kNoKey && is_followed ? slot_key_[slot] : key);
    if (is_followed) slot_key_[slot] = key;
  }
  read_noted_blocks(map);
}

void GroundMap::update(const mapper::ChangedColumns& columns) {
  forget_published_changes();
  const std::size_t cells = columns.cells_per_block;
  assert(columns.keys.empty() || cells == mapper::cells_of(reader_.tables()));
  for (std::size_t i = 0; i < columns.keys.size(); ++i) {
    if (!note_block(columns.keys[i])) continue;
    std::copy_n(columns.cells + i * cells, cells, block_evidence_.data() + places_.back() * cells);
  }
  std::sort(places_.begin(), places_.end());
  sum_up_noted();
}

void GroundMap::note_slots(const VoxelMap& map, std::span<const std::uint32_t> changed_slots) {
  for (const std::uint32_t slot : changed_slots) {
    if (slot < slot_key_.size()) slot_key_[slot] = map.header(slot).key;
  }
}

void GroundMap::rebuild(const VoxelMap& map) {
  forget_published_changes();
  block_evidence_.reset();
  for (std::uint32_t slot = 0; slot < map.slot_end(); ++slot) {
    note_block(map.header(slot).key);
    if (slot < slot_key_.size()) slot_key_[slot] = map.header(slot).key;
  }
  for (const std::uint32_t place : places_) read_block(map, place);
  places_.clear();
  const int stacks = side_blocks_ * side_blocks_;
  for (int stack = 0; stack < stacks; ++stack) sum_up_stack(static_cast<std::uint32_t>(stack));
  published_ = changed_.size();
}

void GroundMap::forget_published_changes() {
  changed_.erase(changed_.begin(), changed_.begin() + static_cast<std::ptrdiff_t>(published_));
  published_ = 0;
}

bool GroundMap::note_block(BlockKey key) {
  if (key == VoxelMap::kNoKey) return false;
  const mapper::VoxelIndex block = mapper::decode(key);
  if (block.z < reader_.first_block_z() || block.z > reader_.last_block_z()) return false;
  const std::int32_t column = block.x - first_block_x_;
  const std::int32_t row = block.y - first_block_y_;
  if (column < 0 || row < 0 || column >= side_blocks_ || row >= side_blocks_) return false;
  const std::int32_t layer = block.z - reader_.first_block_z();
  places_.push_back(static_cast<std::uint32_t>((row * side_blocks_ + column) * block_layers_ + layer));
  return true;
}

void GroundMap::read_noted_blocks(const VoxelMap& map) {
  // The order in which a frame's blocks are reported depends on threads; what comes out of here must not.
  std::sort(places_.begin(), places_.end());
  for (const std::uint32_t place : places_) read_block(map, place);
  sum_up_noted();
}

/// Stack by stack; places_ is sorted.
void GroundMap::sum_up_noted() {
  const auto layers = static_cast<std::uint32_t>(block_layers_);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const std::uint32_t stack = places_[i] / layers;
    if (i + 1 == places_.size() || places_[i + 1] / layers != stack) sum_up_stack(stack);
  }
  places_.clear();
  published_ = changed_.size();
}

void GroundMap::read_block(const VoxelMap& map, std::uint32_t place) {
  const int stack = static_cast<int>(place) / block_layers_;
  const std::int32_t block_z = reader_.first_block_z() + static_cast<int>(place) % block_layers_;
  const auto side = static_cast<std::size_t>(reader_.cells_per_block());
  const std::size_t cells = side * side;
  const std::span<Evidence> said{block_evidence_.data() + place * cells, cells};
  const std::uint32_t slot =
      map.find(mapper::encode({first_block_x_ + stack % side_blocks_, first_block_y_ + stack / side_blocks_, block_z}));
  if (slot == mapper::kNoSlot) {
    std::fill(said.begin(), said.end(), Evidence{0});
  } else {
    reader_.read(map, slot, block_z, said);
  }
}

void GroundMap::sum_up_stack(std::uint32_t stack) {
  const int column = static_cast<int>(stack) % side_blocks_;
  const int row = static_cast<int>(stack) / side_blocks_;
  const int side = reader_.cells_per_block();
  const int cells = side * side;
  const Evidence* said = block_evidence_.data() + static_cast<std::size_t>(stack) * static_cast<std::size_t>(cells) *
                                                      static_cast<std::size_t>(block_layers_);
  for (int i = 0; i < cells; ++i) {
    Evidence sum = 0;
    for (int layer = 0; layer < block_layers_; ++layer) sum = together(sum, said[layer * cells + i]);
    set_evidence({column * side + i % side, row * side + i / side}, settled(sum));
  }
}

void GroundMap::set_evidence(Cell c, Evidence from_voxels) {
  Marked& evidence = evidence_[states_.index(c)];
  const Marked before = evidence & kFromVoxels;
  if (from_voxels == before) return;
  const bool was_free_floor = (before & kFloorSeen) != 0 && states_.at(c) == CellState::free;
  evidence = static_cast<Marked>((evidence & ~kFromVoxels) | from_voxels);
  const Marked flipped = from_voxels ^ before;
  if ((flipped & kDropSeen) != 0) spread(c, drops_near_, (from_voxels & kDropSeen) != 0 ? 1 : -1);
  if ((flipped & kFloorSeen) != 0) spread(c, floors_near_, (from_voxels & kFloorSeen) != 0 ? 1 : -1);
  if ((flipped & kHitOnce) != 0) refresh_around(c);
  refresh(c);
  if (states_.at(c) != CellState::occupied) {
    evidence &= static_cast<Marked>(~kCameLater);
  } else if (was_free_floor) {
    evidence |= kCameLater;
  }
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
  const Marked evidence = evidence_[index];
  const bool floor_seen = (evidence & kFloorSeen) != 0;
  if ((evidence & (kObstacle | kStep)) != 0) return CellState::occupied;
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
    Marked& evidence = evidence_[states_.index(c)];
    evidence = static_cast<Marked>(evidence | kContact | ((evidence & kFloorSeen) != 0 ? kDistrusted : 0));
    refresh(c);
  });
}

void GroundMap::mark_step(Cell c, bool is_step) {
  if (!states_.contains(c)) return;
  Marked& evidence = evidence_[states_.index(c)];
  evidence = static_cast<Marked>(is_step ? evidence | kStep : evidence & ~kStep);
  refresh(c);
}

void GroundMap::forget_marks() {
  for (std::size_t i = 0; i < evidence_.size(); ++i) {
    if ((evidence_[i] & ~kFromVoxels) == 0) continue;
    evidence_[i] &= kFromVoxels;
    refresh(states_.cell(i));
  }
}

void GroundMap::forget_contacts() {
  for (std::size_t i = 0; i < evidence_.size(); ++i) {
    if ((evidence_[i] & kContact) == 0) continue;
    evidence_[i] &= static_cast<Marked>(~(kContact | kDistrusted));
    refresh(states_.cell(i));
  }
}

}  // namespace g3d::nav
