// SPDX-License-Identifier: Apache-2.0
// How an integrator finds the voxels that a frame saw through. One interface, three ways; hits and updates are shared.
#pragma once

#include "mapper/cpu/block_updater.hpp"
#include "mapper/cpu/depth_pyramid.hpp"
#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cpu/hit_scatter.hpp"
#include "mapper/cpu/ray_ends.hpp"
#include "mapper/cpu/thread_pool.hpp"

namespace g3d::mapper::cpu {

/// One frame on its way into the map.
struct FrameWork {
  const SensorGeometry& sensor;
  const FrameGeometry& frame;
  const RayEnds& ends;
  const DepthPyramid& pyramid;
  HitScatter& hits;
  BlockUpdater& updater;
  const Kernels& kernels;
  ThreadPool& pool;
  bool with_colour;
  std::uint32_t frame_number;
};

class FreeSpace {
 public:
  virtual ~FreeSpace() = default;
  /// Begins the updater and offers it every block with free voxels, together with the block's hits.
  virtual void offer(const FrameWork& work) = 0;
};

}  // namespace g3d::mapper::cpu
