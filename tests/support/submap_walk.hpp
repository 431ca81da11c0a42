// SPDX-License-Identifier: Apache-2.0
// A walk up and down the corridor that is kept as a chain of submaps, with a window around the camera if one is opened.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "hal/frame_pool.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/mapper.hpp"
#include "mapper/submaps/submap_blocks.hpp"
#include "mapper/submaps/submap_chain.hpp"
#include "mapper/submaps/view_window.hpp"
#include "tests/support/corridor_walk.hpp"
#include "tests/support/memory_page_file.hpp"

namespace g3d::tests {

inline constexpr mapper::MapCapacity kPlentyOfBlocks{1U << 16, 1U << 15, 1U << 16};

struct SubmapWalk {
  explicit SubmapWalk(const mapper::submaps::ChainOptions& options = {},
                      const mapper::MapCapacity& capacity = kPlentyOfBlocks)
      : mapper(config(capacity), CorridorWalk::camera()), chain(mapper.map(), options, &shelf) {}

  void open_window(double radius_m = 0.0) {
    const mapper::submaps::ViewWindowConfig window_config{radius_m, mapper.config().near_m, mapper.config().far_m};
    window = std::make_unique<mapper::submaps::ViewWindow>(chain, mapper.map(), CorridorWalk::camera(), window_config);
  }
  /// True: it has ended a submap.
  bool step(const hal::Pose& pose) {
    frame.stamp_ns = hal::TimeNs{100'000'000} * ++steps;
    walk.draw(pose, frame);
    if (window) window->prepare(pose);
    const mapper::FrameReport report = mapper.integrate(frame, pose);
    if (report.status == mapper::FrameStatus::out_of_range) return false;
    refused += report.refused_blocks;
    last_pose = pose;
    const bool is_due = chain.add_frame(frame.stamp_ns, pose, mapper.changed_slots());
    return (is_due || (window && window->wants_submap())) && chain.finish_submap();
  }
  void go(int count) {
    for (int i = 0; i < count; ++i) step(walk.pose(next++));
  }
  /// Of all that is known, wherever it lies.
  [[nodiscard]] std::string hash() {
    if (!window) return mapper::map_hash(mapper.map());
    return mapper::map_hash(mapper::submaps::SubmapBlocks(chain, *window));
  }
  [[nodiscard]] std::uint32_t blocks() const { return chain.view().block_count(); }

  static mapper::MapperConfig config(const mapper::MapCapacity& capacity) {
    mapper::MapperConfig config;
    config.capacity = capacity;
    return config;
  }

  CorridorWalk walk;
  mapper::Mapper mapper;
  hal::Frame frame = hal::make_frame(CorridorWalk::camera());
  MemoryPageFile* disk = new MemoryPageFile;  ///< the shelf's
  mapper::submaps::SubmapShelf shelf{std::unique_ptr<mapper::PageFile>(disk)};
  mapper::submaps::SubmapChain chain;
  std::unique_ptr<mapper::submaps::ViewWindow> window;
  hal::Pose last_pose;
  std::uint64_t refused = 0;
  int steps = 0;
  int next = 0;
};

}  // namespace g3d::tests
