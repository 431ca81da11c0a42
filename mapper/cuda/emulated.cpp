// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/target_host.hpp"
//
#include <algorithm>
#include <cstring>
#include <numeric>

#include "mapper/cuda/emulated.hpp"
#include "mapper/cuda/kernels/launches.hpp"

namespace g3d::mapper::cuda {
namespace {

constexpr std::uint32_t kRoom = 512;  // little, so that tests see more than one round
constexpr std::uint32_t kClassRoom = 2048;
constexpr std::uint32_t kFewRays = 500;
constexpr std::uint32_t kLookRoom = 3;
constexpr std::uint32_t kFewColumns = 100;

MemorySizes with_little_room(MemorySizes sizes) {
  sizes.rays = std::min(sizes.rays, kFewRays);
  sizes.looks = std::min(sizes.looks, kLookRoom);
  sizes.columns = std::min(sizes.columns, kFewColumns);
  return sizes;
}

}  // namespace

Emulated::Emulated(const MemorySizes& sizes, std::span<const float> column_slope, std::span<const float> row_slope,
                   std::span<const std::uint16_t> mask, std::uint64_t seed)
    : sizes_(with_little_room(sizes)),
      random_(seed * 0x9E3779B97F4A7C15ULL + 1),
      bytes_(place(memory_, sizes_, 0) + kAlign_bytes),
      heads_(kRoom),
      planes_(kRoom),
      bricks_(std::size_t{kRoom} * kBricks),
      class_heads_(kClassRoom),
      class_planes_(kClassRoom) {
  const std::uintptr_t base =
      (reinterpret_cast<std::uintptr_t>(bytes_.data()) + kAlign_bytes - 1) / kAlign_bytes * kAlign_bytes;
  place(memory_, sizes_, base);
  std::memset(memory_.hits, 0xFF, hits_bytes(sizes_));
  *memory_.state = initial_state(sizes_);
  std::copy(column_slope.begin(), column_slope.end(), memory_.column_slope);
  std::copy(row_slope.begin(), row_slope.end(), memory_.row_slope);
  std::copy(mask.begin(), mask.end(), memory_.mask);
  parcels_ = {heads_.data(), planes_.data(), bricks_.data()};
  classes_ = {class_heads_.data(), class_planes_.data()};
  queries_ = {memory_.rays, memory_.ray_hits, memory_.looks};
  grid_question_ = {memory_.spread, memory_.grid_costs, memory_.grid_distances};
  columns_ = {memory_.column_keys, memory_.column_cells};
  alignment_ = {memory_.align.question, memory_.align.state, memory_.align.parcel,
                touched_room(tiles_of(sizes.width_px, sizes.height_px), sizes.surface_slots)};
}

std::uint64_t Emulated::next_random() {
  random_ ^= random_ << 13;
  random_ ^= random_ >> 7;
  random_ ^= random_ << 17;
  return random_ >> 16;
}

void Emulated::shuffle(std::vector<int>& order) {
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[next_random() % i]);
}

template <typename Kernel>
void Emulated::launch(int blocks, int threads, Kernel&& kernel) {
  std::vector<int> block_order(static_cast<std::size_t>(blocks));
  std::vector<int> thread_order(static_cast<std::size_t>(threads));
  std::iota(block_order.begin(), block_order.end(), 0);
  std::iota(thread_order.begin(), thread_order.end(), 0);
  shuffle(block_order);
  for (const int index : block_order) {
    shuffle(thread_order);
    kernel(Block(index, blocks, thread_order));
  }
}

// Counts of blocks are odd ones, so that what is dealt out to them comes in uneven shares.
bool Emulated::import_blocks(std::uint32_t count) {
  launch(7, kParcelThreads, [&](const Block& block) { cuda::import_blocks(block, memory_, parcels_, count); });
  return true;
}

bool Emulated::finish_frame(FrameCounters& counters) {
  launch(41, kPixelThreads, [&](const Block& block) { read_image(block, memory_, memory_.input->params); });
  if (walks_rays(memory_.input->params.free_by)) {
    launch(23, kPixelThreads, [&](const Block& block) { walk_image(block, memory_, memory_.input->params); });
  }
  launch(43, kPixelThreads, [&](const Block& block) { find_work(block, memory_, memory_.input->params); });
  // Both kernels give the same map, so every frame may choose.
  launch(53, kUpdateThreads, [&, one = next_random() % 2 == 0](const Block& block) {
    one ? update_map<1>(block, memory_, memory_.input->params) : update_map<4>(block, memory_, memory_.input->params);
  });
  launch(13, kParcelThreads, [&](const Block& block) {
    export_classes(block, memory_, memory_.input->params, classes_, &counters, class_room());
  });
  return true;
}

bool Emulated::send_blocks(std::uint32_t first) {
  launch(11, kParcelThreads, [&](const Block& block) { export_blocks(block, memory_, parcels_, first, room()); });
  return true;
}

bool Emulated::set_columns(const ColumnTables& tables) {
  *memory_.column_tables = tables;
  return true;
}

bool Emulated::read_columns(std::uint32_t first) {
  launch(5, kParcelThreads, [&](const Block& block) { cuda::read_columns(block, memory_, first, column_room()); });
  return true;
}

bool Emulated::cast_rays(std::uint32_t count, float resolution_m) {
  launch(3, kParcelThreads, [&](const Block& block) { cuda::cast_rays(block, memory_, resolution_m, count); });
  return memory_.state->refused_imports == 0;
}

bool Emulated::count_looks(std::uint32_t count, const LookModel& model) {
  launch(5, kPixelThreads, [&](const Block& block) { mark_looks(block, memory_, model, count); });
  launch(7, kPixelThreads, [&](const Block& block) { cuda::count_looks(block, memory_, count); });
  return memory_.state->refused_imports == 0;
}

bool Emulated::spread_grid() {
  launch(3, kPixelThreads, [&](const Block& block) { begin_spread(block, memory_); });
  for (std::uint32_t round = 0; memory_.awake_counts[round % 3] != 0; ++round) {
    launch(5, kPixelThreads, [&](const Block& block) { spread_round(block, memory_, round); });
  }
  return true;
}

bool Emulated::import_cells(std::uint32_t first, std::uint32_t count) {
  launch(3, kPixelThreads, [&](const Block& block) { cuda::import_cells(block, memory_, first, count); });
  return true;
}

bool Emulated::finish_fit() {
  launch(5, kPixelThreads, [&](const Block& block) { read_tiles(block, memory_); });
  launch(3, kPixelThreads, [&](const Block& block) { find_samples(block, memory_); });
  launch(7, kPixelThreads, [&](const Block& block) { count_chosen(block, memory_); });
  launch(5, kPixelThreads, [&](const Block& block) { choose(block, memory_); });
  for (int step = 0; step <= memory_.align.question->fit.most_steps; ++step) {
    launch(5, kParcelThreads, [&](const Block& block) { match_step(block, memory_, step); });
  }
  return true;
}

bool Emulated::add_samples() {
  launch(5, kPixelThreads, [&](const Block& block) { place_samples(block, memory_); });
  launch(3, kPixelThreads, [&](const Block& block) { lead_cells(block, memory_); });
  launch(7, kPixelThreads, [&](const Block& block) { cuda::add_samples(block, memory_); });
  if (memory_.align.question->looks_at_map != 0) {
    launch(5, kPixelThreads, [&](const Block& block) { sweep_cells(block, memory_); });
  }
  launch(3, kPixelThreads, [&](const Block& block) { export_cells(block, memory_, alignment_.cell_room); });
  return true;
}

}  // namespace g3d::mapper::cuda
