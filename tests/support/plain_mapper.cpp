// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plain_mapper.hpp"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <cmath>

namespace g3d::test {

using namespace mapper;

void plain_update(PlainVoxel& voxel, bool hit, Seen seen, const std::uint8_t* rgb, UpdateSteps steps) {
  if (hit) {
    voxel.level = after_hit(voxel.level, steps);
  } else if (seen == Seen::strong || (seen == Seen::weak && state_of_level(voxel.level) != State::occupied)) {
    voxel.level = after_miss(voxel.level, steps);
  }
  if (state_of_level(voxel.level) != State::occupied) {
    voxel.has_colour = false;
    voxel.rgb = {};
  } else if (rgb != nullptr) {
    for (std::size_t c = 0; c < 3; ++c) voxel.rgb[c] = voxel.has_colour ? blend_channel(voxel.rgb[c], rgb[c]) : rgb[c];
    voxel.has_colour = true;
  }
}

PlainMapper::PlainMapper(const MapperConfig& config, const hal::CameraModel& camera,
                         std::span<const std::uint16_t> scan_mask)
    : config_(config),
      sensor_(camera, config.resolution_m, config.near_m, config.far_m),
      mask_(scan_mask.begin(), scan_mask.end()) {
  const auto everywhere =
      static_cast<std::uint16_t>(std::nearbyint(config.mask_depth_m * camera.depth_units_per_metre));
  if (mask_.empty()) mask_.assign(camera.pixel_count(), everywhere);
}

PlainVoxel& PlainMapper::voxel(MCode code) { return blocks_[code >> kBlockShift][code & kPlaceMask]; }

PlainVoxel PlainMapper::at(MCode code) const {
  const auto block = blocks_.find(code >> kBlockShift);
  return block == blocks_.end() ? PlainVoxel{} : block->second[code & kPlaceMask];
}

void PlainMapper::integrate(const hal::Frame& frame, const hal::Pose& T_world_camera) {
  const auto geometry = cpu::frame_geometry(sensor_, hal::to_transform(T_world_camera));
  if (!geometry) return;
  const std::uint16_t* depth = frame.depth.get();
  const std::vector<std::uint16_t> ends = plain_ray_ends(sensor_, depth, mask_, config_.carve_invalid);
  const PlainHits hits = plain_hits(sensor_, *geometry, depth);
  const std::set<MCode> held = plain_held(sensor_, *geometry, depth);
  if (config_.mode == MapMode::dynamic_mode) {
    for (const auto& [code, seen] : plain_free(sensor_, *geometry, depth, ends, config_.integrator)) {
      if (!hits.contains(code) && !held.contains(code)) plain_update(voxel(code), false, seen, nullptr, config_.steps);
    }
  }
  const bool with_colour = config_.with_colour && frame.has_colour;
  for (const auto& [code, hit] : hits) {
    const std::uint8_t* rgb = with_colour && hit.has_colour ? frame.rgb.get() + 3 * std::size_t{hit.pixel} : nullptr;
    plain_update(voxel(code), true, Seen::no, rgb, config_.steps);
  }
}

std::string PlainMapper::hash() const {
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, 32);
  for (const auto& [key, block] : blocks_) {
    if (std::all_of(block.begin(), block.end(), [](const PlainVoxel& v) { return v.level == kUnknownLevel; })) continue;
    std::vector<std::uint8_t> bytes;
    for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::uint8_t>(key >> (8 * i)));
    for (const PlainVoxel& v : block) bytes.insert(bytes.end(), {v.level, v.rgb[2], v.rgb[1], v.rgb[0]});
    crypto_generichash_update(&state, bytes.data(), bytes.size());
  }
  std::uint8_t digest[32];
  crypto_generichash_final(&state, digest, sizeof digest);
  char hex[65];
  return sodium_bin2hex(hex, sizeof hex, digest, sizeof digest);
}

std::string PlainMapper::differences(const VoxelMap& map) const {
  std::string text;
  int count = 0;
  std::vector<BlockKey> keys = map.sorted_keys();
  for (const auto& [key, block] : blocks_) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  for (const BlockKey key : keys) {
    for (MCode place = 0; place < kBlockVoxels; ++place) {
      const MCode code = (key << kBlockShift) | place;
      const PlainVoxel v = at(code);
      const Rgbo plain = make_rgbo(v.rgb[0], v.rgb[1], v.rgb[2], v.level);
      if (plain == map.at(code) || ++count > 5) continue;
      const VoxelIndex k = decode(code);
      text += fmt::format("({}, {}, {}): plain {:08x}, map {:08x}\n", k.x, k.y, k.z, plain, map.at(code));
    }
  }
  return count == 0 ? text : text + fmt::format("{} voxels differ", count);
}

}  // namespace g3d::test
